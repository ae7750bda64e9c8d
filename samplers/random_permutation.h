// A seeded permutation of [0, size) that is computed, not stored. It gives any element in constant
// time.
//
// Rounds of invertible operations permute the words below the next power of two: additions and
// multiplications carry bits upwards, and a shifted xor carries them downwards. The rounds are
// repeated until the word is below `size`. This cycle walking leaves a permutation of [0, size)
// (Black & Rogaway 2002, "Ciphers with Arbitrary Finite Domains", section 3; first used for samples
// by Kensler 2013, "Correlated Multi-Jittered Sampling").
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

#include "renderer/core/hash.h"

namespace emberline {

class RandomPermutation {
 public:
  // size: 1 to 2^31; key: a well-mixed word.
  RandomPermutation(uint32_t size, uint32_t key)
      : size_(size), mask_(std::bit_ceil(size) - 1), shift_(downward_shift(mask_)) {
    for (uint32_t r = 0; r < kRounds; ++r) key_[r] = hash32(key + r * 0x9e3779b9u);
  }

  uint32_t operator()(uint32_t i) const {
    do i = step(i);
    while (i >= size_);
    return i;
  }

  // Writes the permuted indices of first .. first + count - 1 to `places`, which must hold `count`
  // elements. The loops vectorise: all lanes iterate until the last one is done.
  void places(uint32_t first, int count, uint32_t* places) const {
    uint32_t outside = 0;
    for (int i = 0; i < count; ++i) {
      places[i] = step(first + uint32_t(i));
      outside |= uint32_t(places[i] >= size_);
    }
    while (outside) {
      outside = 0;
      for (int i = 0; i < count; ++i) {
        const uint32_t next = step(places[i]);
        places[i] = places[i] >= size_ ? next : places[i];
        outside |= uint32_t(places[i] >= size_);
      }
    }
  }

 private:
  // With 8 rounds, any two elements reach each pair of positions equally often, to within 5 %. With
  // 4 rounds, this holds only to within 40 %.
  static constexpr uint32_t kRounds = 8;

  // Half the word's bits, so that each round mixes the upper half into the lower half.
  static uint32_t downward_shift(uint32_t mask) {
    return std::max(1u, uint32_t(std::bit_width(mask)) / 2);
  }

  uint32_t step(uint32_t x) const {
    for (uint32_t r = 0; r < kRounds; ++r) {
      x = ((x + key_[r]) * ((key_[r] >> 15) | 1u)) & mask_;
      x ^= x >> shift_;
    }
    return x;
  }

  uint32_t size_, mask_, shift_;
  uint32_t key_[kRounds];
};

}  // namespace emberline
