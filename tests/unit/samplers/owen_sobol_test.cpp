// Compares the hash forms of samplers/owen_sobol.h with naive forms, and tests the nets of
// SobolSampler.
#include "samplers/owen_sobol.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <vector>

#include "renderer/core/constants.h"
#include "renderer/core/vector.h"
#include "support/pair_coupling.h"
#include "unit/sample_statistics.h"

namespace emberline {
namespace {

using namespace owen_sobol;

uint32_t random_word(uint32_t i) { return uint32_t(hash64(0x7e57u + uint64_t(i))); }

uint32_t naive_reverse(uint32_t x) {
  uint32_t result = 0;
  for (int bit = 0; bit < 32; ++bit) result |= ((x >> bit) & 1u) << (31 - bit);
  return result;
}

// The second Sobol' dimension by direction numbers. Its primitive polynomial is x + 1, so v_1 = 1/2
// and v_k = v_{k-1} ^ (v_{k-1} / 2) (Bratley & Fox 1988, algorithm 659).
uint32_t naive_sobol_dimension_1(uint32_t index) {
  uint32_t result = 0;
  uint32_t direction = 0x80000000u;
  for (; index != 0; index >>= 1, direction ^= direction >> 1) {
    if (index & 1u) result ^= direction;
  }
  return result;
}

TEST(OwenSobol, ReverseBitsAgreesWithTheLoop) {
  for (uint32_t i = 0; i < 100000; ++i) {
    ASSERT_EQ(reverse_bits(random_word(i)), naive_reverse(random_word(i)));
  }
}

TEST(OwenSobol, PascalAgreesWithDirectionNumbers) {
  for (uint32_t i = 0; i < 100000; ++i) {
    ASSERT_EQ(reverse_bits(pascal(i)), naive_sobol_dimension_1(i)) << "index " << i;
    const uint32_t large = random_word(i);
    ASSERT_EQ(reverse_bits(pascal(large)), naive_sobol_dimension_1(large)) << "index " << large;
  }
  for (uint32_t i = 0; i < 8; ++i) EXPECT_EQ(pascal_below_8(i), pascal(i));
}

// A permutation of bit-reversed numbers is an Owen scramble if the flip of bit b depends only on
// the bits below b.
TEST(OwenSobol, PermuteFlipsEachBitByLowerBitsOnly) {
  for (uint32_t i = 0; i < 20000; ++i) {
    const uint32_t x = random_word(2 * i), seed = random_word(2 * i + 1);
    const uint32_t bit = 1u << (i % 32);
    const uint32_t changed = permute(x, seed) ^ permute(x ^ bit, seed);
    ASSERT_EQ(changed & (bit - 1), 0u) << "x " << x << " seed " << seed;
    ASSERT_EQ(changed & bit, bit) << "x " << x << " seed " << seed;
  }
}

// Every node of the scramble's tree down to depth 6 flips for half of the seeds. The limit of |z| <
// 6 for each of 63 nodes has a false-alarm rate of 1e-7.
TEST(OwenSobol, PermuteFlipsEachNodeForHalfOfTheSeeds) {
  constexpr uint32_t kSeeds = 40000;
  for (uint32_t depth = 0; depth < 6; ++depth) {
    for (uint32_t node = 0; node < (1u << depth); ++node) {
      uint32_t flips = 0;
      for (uint32_t s = 0; s < kSeeds; ++s) flips += (permute(node, hash32(s)) >> depth) & 1u;
      const double z = (flips - 0.5 * kSeeds) / std::sqrt(0.25 * kSeeds);
      EXPECT_LT(std::abs(z), 6.0) << "depth " << depth << " node " << node;
    }
  }
}

// Owen's own definition has one independent random flip per node of the binary tree. Here the flip
// is a hash of (seed, depth, digits above).
uint32_t naive_owen_scramble(uint32_t x, uint32_t seed) {
  uint32_t result = 0;
  for (uint32_t depth = 0; depth < 24; ++depth) {
    const uint32_t above = depth == 0 ? 0 : x >> (32 - depth);
    const uint32_t flip =
        uint32_t(hash64((uint64_t(seed) << 32) ^ hash64(above + (uint64_t(depth) << 32)))) & 1u;
    result |= (((x >> (31 - depth)) & 1u) ^ flip) << (31 - depth);
  }
  return result;
}

// The hashed scramble must integrate as well as the real one. Compares their variances over 20000
// seeds for a tilted edge with 64 points. The standard deviation of the ratio is 1.4 %, and the
// tolerance is 7 deviations.
TEST(OwenSobol, HashedScrambleIntegratesLikeOwens) {
  constexpr uint32_t kSeeds = 20000, kPoints = 64;
  constexpr double kExact = 0.3 + 0.37 / 2;
  double hashed = 0, naive = 0;
  for (uint32_t s = 0; s < kSeeds; ++s) {
    const uint32_t seed_x = random_word(2 * s), seed_y = random_word(2 * s + 1);
    int inside_hashed = 0, inside_naive = 0;
    for (uint32_t i = 0; i < kPoints; ++i) {
      const float hx = reversed_to_unit_float(permute(i, seed_x));
      const float hy = reversed_to_unit_float(permute(pascal(i), seed_y));
      inside_hashed += hy < 0.3f + 0.37f * hx;
      const float nx = to_unit_float(naive_owen_scramble(naive_reverse(i), seed_x));
      const float ny = to_unit_float(naive_owen_scramble(naive_sobol_dimension_1(i), seed_y));
      inside_naive += ny < 0.3f + 0.37f * nx;
    }
    hashed += square(inside_hashed / double(kPoints) - kExact);
    naive += square(inside_naive / double(kPoints) - kExact);
  }
  EXPECT_NEAR(hashed / naive, 1.0, 0.1);
}

TEST(OwenSobol, NoNumberIsOne) {
  EXPECT_EQ(reversed_to_unit_float(0xffffffffu), kOneMinusEpsilon);
  EXPECT_EQ(reversed_to_unit_float(0u), 0.0f);
  for (uint32_t i = 0; i < 10000; ++i) {
    ASSERT_EQ(reversed_to_unit_float(random_word(i)), to_unit_float(reverse_bits(random_word(i))));
  }
}

TEST(OwenSobol, ShuffleKeepsAlignedBlocksTogether) {
  for (uint32_t s = 0; s < 1000; ++s) {
    const uint32_t seed = hash32(s), log_size = s % 8;
    const uint32_t first = (random_word(s) >> log_size) << log_size;
    for (uint32_t i = 1; i < (1u << log_size); ++i) {
      ASSERT_EQ(shuffle_index(first + i, seed) >> log_size, shuffle_index(first, seed) >> log_size);
    }
  }
}

uint32_t naive_order_of_8(uint32_t bits) {
  std::array<uint32_t, 8> order = {0, 1, 2, 3, 4, 5, 6, 7};
  double fraction = double(bits >> 4) / double(1 << 28);
  for (uint32_t n = 8; n > 1; --n) {
    const auto pick = size_t(fraction * n);
    fraction = fraction * n - double(pick);
    std::swap(order[pick], order[n - 1]);
  }
  uint32_t packed = 0;
  for (size_t i = 0; i < 8; ++i) packed |= order[i] << (4 * i);
  return packed;
}

// apply_order() maps each aligned block of 2^m indices to an aligned block of 2^m indices. So pairs
// of dimensions remain (0,2)-sequences in every Order.
TEST(OwenSobol, OrdersKeepAlignedBlocksTogether) {
  for (int o = 0; o < kOrders; ++o) {
    for (uint32_t bit = 0; bit < 32; ++bit) {
      ASSERT_EQ(apply_order(1u << bit, Order(o)) >> bit, 1u) << "order " << o;
    }
    for (uint32_t k = 0; k < 1000; ++k) {
      const uint32_t i = random_word(k), j = random_word(k + 1000);
      ASSERT_EQ(apply_order(i ^ j, Order(o)), apply_order(i, Order(o)) ^ apply_order(j, Order(o)));
      ASSERT_EQ((apply_order_to_8(Order(o)) >> (4 * (i & 7u))) & 15u,
                apply_order(i & 7u, Order(o)));
    }
  }
}

// The variance relative to random numbers, for integrands that couple the parts `a` and `b`. Over
// random orders it is 1 on average.
template <typename A, typename B>
double coupling(Order x, Order y, uint32_t m, const A& a, const B& b) {
  double sum = 0;
  for (uint32_t i = 0; i < 1u << m; ++i) sum += a(apply_order(i, x)) * b(apply_order(i, y));
  return sum / (a(0) * b(0));
}

TEST(OwenSobol, OrdersGoTogether) {
  const std::map<uint32_t, double> limits = {{4, 2.8}, {5, 1.4}, {6, 0.85}, {8, 0.45}, {10, 0.2}};
  for (const auto& [m, limit] : limits) {
    for (int b = 0; b < kOrders; ++b) {
      const bool time = Order(b) == Order::kTime;
      for (int a = 0; a < b; ++a) {
        const double found = time ? coupling(Order(a), Order(b), m, test::pair_sum, test::first_sum)
                                  : coupling(Order(a), Order(b), m, test::pair_sum, test::pair_sum);
        EXPECT_LT(found, limit) << "orders " << a << " and " << b << ", 2^" << m << " points";
      }
    }
    EXPECT_LT(coupling(Order::kPixel, Order::kTime, m, test::first_sum, test::first_sum), 1.1);
    EXPECT_LT(coupling(Order::kPixel, Order::kTime, m, test::second_sum, test::first_sum), 1.4);
  }
  // This is the most important coupling.
  EXPECT_LT(coupling(Order::kPixel, Order::kFirst, 6, test::pair_sum, test::pair_sum), 0.31);
}

TEST(OwenSobol, OrdersOfEightAreUniform) {
  std::vector<uint32_t> counts(40320);
  for (uint32_t i = 0; i < 40320 * 50; ++i) {
    const uint32_t order = random_order_of_8(random_word(i));
    if (i < 10000) {
      ASSERT_EQ(order, naive_order_of_8(random_word(i)));
    }
    uint32_t rank = 0;  // Lehmer code
    for (uint32_t a = 0; a < 8; ++a) {
      uint32_t smaller = 0;
      for (uint32_t b = a + 1; b < 8; ++b) {
        smaller += ((order >> (4 * b)) & 15u) < ((order >> (4 * a)) & 15u);
      }
      rank = rank * (8 - a) + smaller;
    }
    ++counts[rank];
  }
  EXPECT_LT(chi_square(counts), chi_square_limit(40319));
}

// Whether each elementary interval 2^-a x 2^-(m - a) holds one point, or at most `most` points.
testing::AssertionResult is_net(const std::vector<std::array<float, 2>>& points, uint32_t m,
                                uint32_t most = 1) {
  for (uint32_t a = 0; a <= m; ++a) {
    std::vector<uint32_t> count(size_t(1) << m);
    for (uint32_t i = 0; i < (1u << m); ++i) {
      const auto column = uint32_t(points[i][0] * float(1u << a));
      const auto row = uint32_t(points[i][1] * float(1u << (m - a)));
      ++count[(size_t(row) << a) + column];
    }
    for (size_t cell = 0; cell < count.size(); ++cell) {
      if (count[cell] > most || (most == 1 && count[cell] == 0)) {
        return testing::AssertionFailure() << "cell " << cell << " of the 2^" << a << " x 2^"
                                           << m - a << " grid holds " << count[cell] << " points";
      }
    }
  }
  return testing::AssertionSuccess();
}

class SobolNets : public testing::TestWithParam<StreamCount> {
 protected:
  // The points of two dimensions in each stream, in the stream's own order.
  std::vector<std::vector<std::array<float, 2>>> points(const PixelKey& pixel, uint32_t slot, int x,
                                                        int y, uint32_t count_per_stream) {
    const auto sampler = create_sampler("sobol", {GetParam()});
    const auto streams = uint32_t(GetParam());
    std::vector<std::vector<std::array<float, 2>>> result(streams);
    for_each_sample(*sampler, pixel, slot, count_per_stream * streams,
                    [&](uint32_t k, const SlotNumbers& n) {
                      const uint32_t stream = streams == 2 ? (k >> 3) & 1u : 0;
                      result[stream].push_back({n.u[x], n.u[y]});
                    });
    return result;
  }
};

TEST_P(SobolNets, EveryPowerOfTwoPrefixOfThePixelPairIsANet) {
  for (uint32_t p = 0; p < 20; ++p) {
    const PixelKey pixel{random_word(p), p, p / 2};
    for (const auto& stream : points(pixel, 0, 0, 1, 1024)) {
      for (uint32_t m = 0; m <= 10; ++m)
        ASSERT_TRUE(is_net(stream, m)) << "m " << m << " pixel " << p;
    }
  }
}

TEST_P(SobolNets, OtherPairsKeepTheirNetsAtMultiplesOfSixteen) {
  const uint32_t first_m = GetParam() == StreamCount::kTwo ? 3 : 4;
  for (uint32_t p = 0; p < 6; ++p) {
    for (const uint32_t slot : {0u, 1u, 2u, 7u, 100u}) {
      for (int pair = 0; pair < 4; ++pair) {
        if (slot == 0 && pair == 2) continue;  // time is paired with the pixel
        for (const auto& stream : points({p, 3 * p, 1}, slot, 2 * pair, 2 * pair + 1, 512)) {
          for (uint32_t m = first_m; m <= 9; ++m) {
            ASSERT_TRUE(is_net(stream, m)) << "slot " << slot << " pair " << pair << " m " << m;
          }
        }
      }
    }
  }
}

// Time is stratified together with either coordinate of the pixel.
TEST_P(SobolNets, TimeIsStratifiedWithThePixel) {
  for (uint32_t p = 0; p < 10; ++p) {
    const PixelKey pixel{random_word(p), p, p / 2};
    for (const int other : {camera_dim::kPixelX, camera_dim::kPixelY}) {
      for (const auto& stream : points(pixel, 0, other, camera_dim::kTime, 512)) {
        for (uint32_t m = 0; m <= 9; ++m) {
          ASSERT_TRUE(is_net(stream, m, 4)) << "m " << m << " pixel " << p;
          std::vector<uint32_t> count(size_t(1) << m);
          for (uint32_t i = 0; i < 1u << m; ++i) ++count[size_t(stream[i][1] * float(1u << m))];
          ASSERT_EQ(*std::ranges::max_element(count), 1u) << "m " << m << " pixel " << p;
        }
      }
    }
  }
}

// The aligned batches are anywhere in the sequence, up to the last possible index.
TEST_P(SobolNets, EveryAlignedBatchIsStratified) {
  const auto sampler = create_sampler("sobol", {GetParam()});
  const auto streams = uint32_t(GetParam());
  const uint32_t m = streams == 2 ? 3 : 4;
  for (uint32_t i = 0; i < 2000; ++i) {
    uint32_t first = random_word(i) & ~15u;
    if (i == 0) first = 0xfffffff0u;
    if (i == 1) first = 0x7ffffff0u;
    if (i == 2) first = 0x80000000u;
    SlotBlock block;
    sampler->fill({i, 5, 9}, i % 3, first, kSampleLanes, block);
    for (int pair = 0; pair < 4; ++pair) {
      if (i % 3 == 0 && pair == 2) continue;
      for (uint32_t stream = 0; stream < streams; ++stream) {
        std::vector<std::array<float, 2>> batch;
        for (uint32_t lane = stream * 8; lane < 16 && batch.size() < (1u << m); ++lane) {
          batch.push_back({block.values[2 * pair][lane], block.values[2 * pair + 1][lane]});
        }
        ASSERT_TRUE(is_net(batch, m)) << where("sobol", {i, 5, 9}, i % 3, first);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Streams, SobolNets, testing::Values(StreamCount::kOne, StreamCount::kTwo),
                         [](const auto& test) {
                           return test.param == StreamCount::kOne ? "One" : "Two";
                         });

}  // namespace
}  // namespace emberline
