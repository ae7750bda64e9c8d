// Integer hashes. Every seed is computed with them, because raw indices would give correlated
// samples. Each hash is bijective or mixes well.
#pragma once

#include <bit>
#include <cstdint>

namespace emberline {

// A 32-bit finaliser with low bias, which was found by search (C. Wellons, "Prospecting for Hash
// Functions", 2018). The constants are those of the 2-round variant as improved by T. Ettinger
// (bias 0.107).
constexpr uint32_t hash32(uint32_t x) {
  x ^= x >> 16;
  x *= 0x21f0aaadu;
  x ^= x >> 15;
  x *= 0x735a2d97u;
  x ^= x >> 15;
  return x;
}

// The 64-bit finaliser of SplitMix64 (Steele, Lea & Flood 2014, "Fast Splittable Pseudorandom
// Number Generators"). This is variant 13 of D. Stafford.
constexpr uint64_t hash64(uint64_t x) {
  x ^= x >> 30;
  x *= 0xbf58476d1ce4e5b9ull;
  x ^= x >> 27;
  x *= 0x94d049bb133111ebull;
  x ^= x >> 31;
  return x;
}

// Adds a word to the hash h. The result depends on the order in which words are added. The
// golden-ratio increment keeps 0 from being a fixed point.
constexpr uint32_t hash_combine(uint32_t h, uint32_t word) {
  return hash32((h ^ hash32(word + 0x9e3779b9u)) * 0x85ebca6bu + 0x9e3779b9u);
}

constexpr uint64_t hash_combine64(uint64_t h, uint64_t word) {
  return hash64(h ^ (hash64(word + 0x9e3779b97f4a7c15ull) + 0x9e3779b97f4a7c15ull));
}

// Converts 32 random bits to a uniform float in [0, 1).
constexpr float to_unit_float(uint32_t bits) { return float(bits >> 8) * 0x1p-24f; }

}  // namespace emberline
