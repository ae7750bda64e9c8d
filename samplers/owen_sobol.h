// Owen-scrambled Sobol' points by hash, without stored scrambles.
//
// All functions work on bit-reversed numbers. Let rev() reverse 32 bits. The first two Sobol'
// dimensions are rev(i) and rev(pascal(i)), and an Owen scramble of a number u is
// rev(permute(rev(u))). Inner reversals cancel, so each number of a point costs one reversal:
//     u0 = rev(permute(i, seed0)),  u1 = rev(permute(pascal(i), seed1)).
// Example without seeds: i = 6 = 110b has u0 = .011b = 3/8; pascal(6) = 101b, so u1 = .101b = 5/8.
// All functions are pure and, except for apply_order(), branch-free, so that loops over them
// vectorise.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
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

// A seeded permutation of 32-bit words in which each bit depends only on itself and on lower bits.
// On bit-reversed numbers it is an Owen scramble (Laine & Karras 2011, "Stratified Sampling for
// Stochastic Transparency", section 3.1; Burley 2020, "Practical Hash-based Owen Scrambling", JCGT
// 9(4), section 4). The constants are from N. Vegdahl 2021, "Building a Better LK Hash".
constexpr uint32_t permute(uint32_t x, uint32_t seed) {
  x ^= x * 0x3d20adeau;
  x += seed;
  x *= (seed >> 16) | 1u;
  x ^= x * 0x05526c56u;
  x ^= x * 0x53a22864u;
  return x;
}

// Returns the index that gives a sample's number in the second Sobol' dimension. Multiplies by
// Pascal's triangle modulo 2 in log2(32) steps (Ahmed 2024, "An Implementation Algorithm of 2D
// Sobol Sequence Fast, Elegant, and Compact", EGSR; mirrored here, because indices are
// bit-reversed). The function is linear over xor: pascal(a ^ b) = pascal(a) ^ pascal(b).
constexpr uint32_t pascal(uint32_t i) {
  i ^= i >> 16;
  i ^= (i & 0xff00ff00u) >> 8;
  i ^= (i & 0xf0f0f0f0u) >> 4;
  i ^= (i & 0xccccccccu) >> 2;
  i ^= (i & 0xaaaaaaaau) >> 1;
  return i;
}

// pascal() for i < 8, which needs only two of its five steps.
constexpr uint32_t pascal_below_8(uint32_t i) {
  i ^= i >> 2;
  i ^= (i & 2u) >> 1;
  return i;
}

// Index orders for pairs of dimensions that must be jointly stratified. All pairs share one
// sequence; a pair with an order takes point apply_order(i) for sample i. An order is a matrix
// modulo 2 that multiplies the index's bits. Each bit contributes only to itself and to lower bits.
// Therefore aligned blocks of 2^m stay together, and each pair remains a (0,2)-sequence.
//
// The first kSearchedColumns columns come from tests/bench/pair_orders.cpp. With them, any two
// pairs are also stratified jointly from 64 samples on. With 16 samples or fewer, this is not
// possible for all pairs at once: some numbers of different pairs share their leading digits. The
// search chose numbers that are rarely used together. The other columns, for samples from 4096 on,
// are random.
enum class Order : uint8_t { kPixel, kFirst, kSecond, kChoice, kLens, kTime };
inline constexpr int kOrders = 6;
inline constexpr int kSearchedColumns = 12;

using OrderColumns = std::array<uint32_t, 32>;
inline constexpr std::array<OrderColumns, kOrders> kOrderColumns = [] {
  constexpr uint32_t kSearched[kOrders][kSearchedColumns] = {
      {},
      {1, 2, 5, 11, 16, 33, 67, 254, 365, 565, 1024, 2103},
      {1, 2, 7, 12, 29, 43, 94, 167, 447, 660, 1455, 3700},
      {1, 2, 4, 15, 22, 40, 127, 234, 256, 839, 1169, 3031},
      {1, 3, 6, 14, 25, 63, 82, 231, 451, 794, 1304, 2087},
      {1, 2, 7, 8, 28, 49, 114, 186, 467, 615, 1351, 2544},
  };
  std::array<OrderColumns, kOrders> columns{};
  for (uint32_t bit = 0; bit < 32; ++bit) {
    columns[0][bit] = 1u << bit;
    for (uint32_t order = 1; order < uint32_t(kOrders); ++order) {
      columns[order][bit] = bit < uint32_t(kSearchedColumns)
                                ? kSearched[order][bit]
                                : 1u << bit | (hash_combine(order, bit) & ((1u << bit) - 1u));
    }
  }
  return columns;
}();
constexpr uint32_t apply_order(uint32_t i, Order order) {
  const OrderColumns& columns = kOrderColumns[size_t(order)];
  uint32_t x = 0;
  for (; i != 0; i &= i - 1) x ^= columns[size_t(std::countr_zero(i))];
  return x;
}
// apply_order() for 0..7; element i is in bits [4i, 4i + 3).
constexpr uint32_t apply_order_to_8(Order order) {
  uint32_t elements = 0;
  for (uint32_t i = 0; i < 8; ++i) elements |= apply_order(i, order) << (4 * i);
  return elements;
}

// Returns a uniform number in [0, 1), at most 1 - 2^-24. The result equals
// to_unit_float(reverse_bits(x)). The conversion starts from a signed integer, because every vector
// unit has a single instruction for this.
constexpr float reversed_to_unit_float(uint32_t x) {
  return float(int32_t(reverse_bits(x) >> 8)) * 0x1p-24f;
}

// A nested (Owen) shuffle of sample indices: it maps every aligned block of 2^m indices to an
// aligned block of 2^m indices (Burley 2020, section 5).
constexpr uint32_t shuffle_index(uint32_t index, uint32_t seed) {
  return reverse_bits(permute(reverse_bits(index), seed));
}

// Returns a random permutation of 0..7, with element i in bits [4i, 4i + 3). This is a Fisher-Yates
// shuffle of packed nibbles. It reads the upper 28 random bits as a fraction, whose leading digits
// in base 8, 7, ... 2 pick the swaps. Each of the 8! permutations has probability (1 +- 2e-4) / 8!.
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

// Shuffles a sample index for one pair of dimensions, to make the pair independent of the other
// pairs. Applies an Owen shuffle to blocks of 8, and a random permutation within each block
// (sobol_sampler.h explains why both are needed).
constexpr uint32_t shuffle_in_blocks(uint32_t index, uint32_t seed) {
  const uint32_t block = index >> 3;
  const uint32_t order = random_order_of_8(hash32(hash32(seed) ^ hash32(block + 0x9e3779b9u)));
  return (shuffle_index(block << 3, seed) & ~7u) | ((order >> (4 * (index & 7u))) & 7u);
}

}  // namespace emberline::owen_sobol
