// Owen-scrambled Sobol' points by hash: no tables of direction numbers, no stored scrambles.
//
// Everything here works on the index side of the bit reversal: with rev() the reversal of 32 bits,
// the first two Sobol' dimensions are rev(i) and rev(pascal(i)), and an Owen scramble of a number u
// is rev(permute(rev(u))). The reversals cancel, so that one point costs one reversal per number:
//     u0 = rev(permute(i, seed0)),  u1 = rev(permute(pascal(i), seed1)).
// Worked: i = 6 = 110b has u0 = .011b = 3/8; pascal(6) = 101b, so u1 = .101b = 5/8 (seedless).
// All functions are pure and free of branches, so that loops over them vectorise.
#pragma once

#include <array>
#include <cstdint>

#include "renderer/core/hash.h"

namespace emberline::owen_sobol {

constexpr uint32_t reverse_bits(uint32_t x) {
  x = __builtin_bswap32(x);
  x = ((x & 0x0f0f0f0fu) << 4) | ((x >> 4) & 0x0f0f0f0fu);
  x = ((x & 0x33333333u) << 2) | ((x >> 2) & 0x33333333u);
  x = ((x & 0x55555555u) << 1) | ((x >> 1) & 0x55555555u);
  return x;
}

// A seeded permutation of 32-bit words in which each bit depends on itself and lower bits only:
// on bit-reversed numbers that is an Owen scramble (Laine & Karras 2011, "Stratified Sampling for
// Stochastic Transparency", section 3.1; Burley 2020, "Practical Hash-based Owen Scrambling",
// JCGT 9(4), section 4). Constants: N. Vegdahl 2021, "Building a Better LK Hash".
constexpr uint32_t permute(uint32_t x, uint32_t seed) {
  x ^= x * 0x3d20adeau;
  x += seed;
  x *= (seed >> 16) | 1u;
  x ^= x * 0x05526c56u;
  x ^= x * 0x53a22864u;
  return x;
}

// Index of the second Sobol' dimension: multiplication by Pascal's triangle modulo 2 in
// log2(32) steps (Ahmed 2024, "An Implementation Algorithm of 2D Sobol Sequence Fast, Elegant, and
// Compact", EGSR; here mirrored, since we stand on the index side of the reversal). Linear over
// xor: pascal(a ^ b) = pascal(a) ^ pascal(b).
constexpr uint32_t pascal(uint32_t i) {
  i ^= i >> 16;
  i ^= (i & 0xff00ff00u) >> 8;
  i ^= (i & 0xf0f0f0f0u) >> 4;
  i ^= (i & 0xccccccccu) >> 2;
  i ^= (i & 0xaaaaaaaau) >> 1;
  return i;
}

// Index of the third Sobol' dimension: primitive polynomial x^2 + x + 1, initial numbers 1 and 3
// (S. Joe, F. Kuo 2008, "Constructing Sobol Sequences with Better Two-Dimensional Projections").
constexpr std::array<uint32_t, 32> kThirdColumns = [] {
  std::array<uint64_t, 32> m{1, 3};
  for (size_t k = 2; k < m.size(); ++k) m[k] = (m[k - 1] << 1) ^ (m[k - 2] << 2) ^ m[k - 2];
  std::array<uint32_t, 32> columns{};
  // A number of k + 1 binary digits after the point; here its reversal.
  for (size_t k = 0; k < m.size(); ++k) {
    columns[k] = reverse_bits(uint32_t(m[k]) << (31 - k));
  }
  return columns;
}();
constexpr uint32_t third(uint32_t i) {
  uint32_t x = 0;
  for (size_t k = 0; k < 32; ++k) x ^= kThirdColumns[k] & (0u - ((i >> k) & 1u));
  return x;
}

// pascal() for i < 8 in two of its five steps.
constexpr uint32_t pascal_below_8(uint32_t i) {
  i ^= i >> 2;
  i ^= (i & 2u) >> 1;
  return i;
}

// Uniform in [0, 1), at most 1 - 2^-24. Equal to to_unit_float(reverse_bits(x)); the signed
// conversion is one instruction on every vector unit, the unsigned one is not.
constexpr float reversed_to_unit_float(uint32_t x) {
  return float(int32_t(reverse_bits(x) >> 8)) * 0x1p-24f;
}

// The nested (Owen) shuffle of sample indices: every aligned block of 2^m indices goes to an
// aligned block of 2^m indices (Burley 2020, section 5).
constexpr uint32_t shuffle_index(uint32_t index, uint32_t seed) {
  return reverse_bits(permute(reverse_bits(index), seed));
}

// A random order of 0..7, element i in bits [4i, 4i + 3): Fisher-Yates on packed nibbles. The 28
// random bits are a fraction whose leading digit in base 8, 7, ... 2 picks each partner; each of
// the 8! orders has probability (1 +- 2e-4) / 8!.
constexpr uint32_t random_order_of_8(uint32_t random_bits) {
  uint32_t fraction = random_bits >> 4;
  uint32_t order = 0x76543210u;
  for (uint32_t n = 8; n > 1; --n) {
    const uint32_t scaled = fraction * n;  // below 2^31
    fraction = scaled & 0x0fffffffu;
    const uint32_t pick = (scaled >> 28) * 4;
    const uint32_t last = (n - 1) * 4;
    const uint32_t difference = ((order >> pick) ^ (order >> last)) & 15u;  // 0 if pick == last
    order ^= (difference << pick) ^ (difference << last);
  }
  return order;
}

// Indices in an order of their own, for numbers that are paired with others of the same samples: an
// Owen shuffle of blocks of 8, and a random order in each (sobol_sampler.h says why both).
constexpr uint32_t shuffle_in_blocks(uint32_t index, uint32_t seed) {
  const uint32_t block = index >> 3;
  const uint32_t order = random_order_of_8(hash32(hash32(seed) ^ hash32(block + 0x9e3779b9u)));
  return (shuffle_index(block << 3, seed) & ~7u) | ((order >> (4 * (index & 7u))) & 7u);
}

}  // namespace emberline::owen_sobol
