#include "renderer/core/hash.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "renderer/core/constants.h"

namespace emberline {
namespace {

// Every input bit must flip every output bit half of the time. With 32768 trials the standard
// deviation is .0028. The tolerance of .02 is 7 standard deviations, and leaves room for the
// finalisers' own biases of less than .01. The inputs count up from 0, as pixel coordinates and
// sample indices do.
template <typename Word, typename Hash>
void expect_avalanche(Hash hash) {
  constexpr int kBits = 8 * sizeof(Word);
  constexpr int kTrials = 32768;
  for (int in = 0; in < kBits; ++in) {
    std::vector<int> flips(kBits);
    for (int i = 0; i < kTrials; ++i) {
      const auto difference = Word(hash(Word(i)) ^ hash(Word(i) ^ (Word(1) << in)));
      for (int out = 0; out < kBits; ++out) flips[out] += int((difference >> out) & 1);
    }
    for (int out = 0; out < kBits; ++out) {
      EXPECT_NEAR(flips[out] / double(kTrials), 0.5, 0.02) << "bit " << in << " to bit " << out;
    }
  }
}

TEST(Hash, Avalanche32) {
  expect_avalanche<uint32_t>([](uint32_t x) { return hash32(x); });
}
TEST(Hash, Avalanche64) {
  expect_avalanche<uint64_t>([](uint64_t x) { return hash64(x); });
}
TEST(Hash, AvalancheOfCombinedWord) {
  expect_avalanche<uint32_t>([](uint32_t x) { return hash_combine(12345u, x); });
  expect_avalanche<uint64_t>([](uint64_t x) { return hash_combine64(12345u, x); });
}
TEST(Hash, AvalancheOfCombinedHash) {
  expect_avalanche<uint32_t>([](uint32_t h) { return hash_combine(h, 7u); });
  expect_avalanche<uint64_t>([](uint64_t h) { return hash_combine64(h, 7u); });
}

// A bijection of 2^32 values maps a million inputs to a million different images. A random function
// would have 116 collisions.
template <typename Word, typename Hash>
size_t distinct_images(Hash hash, Word stride) {
  std::vector<Word> images(1000000);
  for (size_t i = 0; i < images.size(); ++i) images[i] = hash(Word(i) * stride);
  std::sort(images.begin(), images.end());
  return size_t(std::unique(images.begin(), images.end()) - images.begin());
}

TEST(Hash, NoTwoInputsMeet) {
  for (const uint32_t stride : {1u, 65536u + 1u, 0x9e3779b9u}) {
    EXPECT_EQ(distinct_images<uint32_t>([](uint32_t x) { return hash32(x); }, stride), 1000000u);
    EXPECT_EQ(distinct_images<uint32_t>([](uint32_t x) { return hash_combine(99u, x); }, stride),
              1000000u);
    EXPECT_EQ(distinct_images<uint32_t>([](uint32_t h) { return hash_combine(h, 99u); }, stride),
              1000000u);
  }
  EXPECT_EQ(distinct_images<uint64_t>([](uint64_t x) { return hash64(x); }, 1ull << 20), 1000000u);
}

// The inverse of an odd number modulo 2^32. The test below uses it to undo the finaliser step by
// step, which proves that the finaliser is a bijection.
uint32_t inverse_of_odd(uint32_t a) {
  uint32_t x = a;                               // the lowest 3 bits are right
  for (int i = 0; i < 4; ++i) x *= 2u - a * x;  // each Newton step doubles that number
  return x;
}
TEST(Hash, Hash32CanBeUndone) {
  for (uint32_t i = 0; i < 100000; ++i) {
    const uint32_t x = i * 0x9e3779b9u;
    uint32_t h = hash32(x);
    h ^= (h >> 15) ^ (h >> 30);
    h *= inverse_of_odd(0x735a2d97u);
    h ^= (h >> 15) ^ (h >> 30);
    h *= inverse_of_odd(0x21f0aaadu);
    h ^= h >> 16;
    ASSERT_EQ(h, x);
  }
}

TEST(Hash, OrderOfWordsMatters) {
  int equal = 0;
  for (uint32_t a = 0; a < 300; ++a) {
    for (uint32_t b = 0; b < a; ++b) {
      equal += hash_combine(hash_combine(0, a), b) == hash_combine(hash_combine(0, b), a);
    }
  }
  EXPECT_EQ(equal, 0);
  EXPECT_NE(hash_combine(0, 0), 0u);
  EXPECT_NE(hash_combine64(0, 0), 0u);
}

// The hashes of neighbouring pixels are uncorrelated, and so are those of (x, y) and (y, x).
TEST(Hash, NeighbouringPixelsAreUncorrelated) {
  constexpr int kSize = 512;
  const auto u = [](int x, int y) {
    return to_unit_float(hash_combine(hash_combine(hash32(1), uint32_t(x)), uint32_t(y))) - 0.5;
  };
  double right = 0, below = 0, diagonal = 0;
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      right += u(x, y) * u(x + 1, y);
      below += u(x, y) * u(x, y + 1);
      diagonal += u(x, y) * u(y, x) * (x != y);
    }
  }
  const double limit = 5.0 / 12.0 * kSize;  // 5 standard deviations: the false-alarm rate is 6e-7
  EXPECT_LT(std::abs(right), limit);
  EXPECT_LT(std::abs(below), limit);
  EXPECT_LT(std::abs(diagonal), limit * std::sqrt(2.0));
}

TEST(Hash, UnitFloatIsBelowOne) {
  EXPECT_EQ(to_unit_float(0u), 0.0f);
  EXPECT_EQ(to_unit_float(0xffu), 0.0f);
  EXPECT_EQ(to_unit_float(0x100u), 0x1p-24f);
  EXPECT_EQ(to_unit_float(0x80000000u), 0.5f);
  EXPECT_EQ(to_unit_float(0xffffffffu), kOneMinusEpsilon);
  EXPECT_EQ(kOneMinusEpsilon, std::nextafter(1.0f, 0.0f));
}

}  // namespace
}  // namespace emberline
