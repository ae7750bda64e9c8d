// Compares the allocation of a budget with the exact optimum, which is found by sorting. Also tests
// how shares are rounded to counts.
#include "renderer/drivers/adaptive/allocation.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "support/chi_square.h"

namespace emberline {
namespace {

using namespace test;

struct Problem {
  std::vector<float> rates;
  std::vector<SampleBounds> bounds;
  double total = 0;
};

std::vector<float> solve(const Problem& p) {
  std::vector<float> counts;
  allocate_samples(p.rates, p.bounds, p.total, &counts);
  return counts;
}

double sum_of(const std::vector<float>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

double sum_at(const Problem& p, double k) {
  double sum = 0;
  for (size_t i = 0; i < p.rates.size(); ++i) {
    sum += std::clamp(k * double(p.rates[i]), double(p.bounds[i].minimum),
                      double(p.bounds[i].maximum));
  }
  return sum;
}

// The factor K of the exact optimum. The sum of the counts is linear in K between the values at
// which a pixel reaches one of its bounds. K is infinite if every pixel that can grow is at its
// maximum.
double exact_k(const Problem& p) {
  std::vector<double> ends = {0.0};
  for (size_t i = 0; i < p.rates.size(); ++i) {
    if (p.rates[i] <= 0.0f) continue;
    ends.push_back(double(p.bounds[i].minimum) / double(p.rates[i]));
    ends.push_back(double(p.bounds[i].maximum) / double(p.rates[i]));
  }
  std::ranges::sort(ends);
  for (size_t e = 1; e < ends.size(); ++e) {
    const double below = sum_at(p, ends[e - 1]), above = sum_at(p, ends[e]);
    if (above < p.total) continue;
    const double part = above > below ? (p.total - below) / (above - below) : 0.0;
    return ends[e - 1] + std::max(0.0, part) * (ends[e] - ends[e - 1]);
  }
  return std::numeric_limits<double>::infinity();
}

// The rates span `decades` decades, and one in eight is zero. The bounds are of all kinds, and some
// minima equal their maxima. The total lies between the sum of the minima and the sum of the
// maxima.
Problem random_problem(uint64_t seed, size_t pixels, double decades) {
  TestRandom random(seed, 0);
  Problem p;
  double minimum = 0, maximum = 0;
  for (size_t i = 0; i < pixels; ++i) {
    const bool zero = random.next() < 0.125f;
    p.rates.push_back(zero ? 0.0f : float(std::pow(10.0, decades * (random.next_double() - 0.5))));
    SampleBounds b;
    b.minimum = std::floor(64.0f * random.next() * random.next());
    b.maximum = random.next() < 0.2f ? b.minimum : b.minimum + std::floor(1000.0f * random.next());
    p.bounds.push_back(b);
    minimum += double(b.minimum);
    // A pixel with a rate of zero stays at its minimum.
    maximum += double(zero ? b.minimum : b.maximum);
  }
  p.total = minimum + (0.02 + 0.96 * random.next_double()) * (maximum - minimum);
  return p;
}

TEST(ShareSamples, IsTheExactOptimum) {
  for (uint64_t seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE("replay with random_problem(" + std::to_string(seed) + ", ...)");
    const size_t pixels = 1 + size_t(seed) * 7;
    const Problem p = random_problem(seed, pixels, 1.0 + double(seed % 6));
    const std::vector<float> counts = solve(p);
    const double k = exact_k(p);
    EXPECT_NEAR(sum_of(counts), p.total, 1e-3 * p.total);
    for (size_t i = 0; i < pixels; ++i) {
      const double exact = std::clamp(k * double(p.rates[i]), double(p.bounds[i].minimum),
                                      double(p.bounds[i].maximum));
      // The bisection stops within a thousandth of the sum, and a few pixels may cause all of this
      // error.
      ASSERT_NEAR(double(counts[i]), exact, 2e-3 * exact + 1e-5) << "pixel " << i;
    }
  }
}

// The Karush-Kuhn-Tucker conditions: One more sample gains (rate / n)^2, and the test compares the
// roots of these gains. The gain is the same for all pixels between their bounds. It is no less for
// a pixel at its maximum, and no more for a pixel at its minimum.
TEST(ShareSamples, NoSampleIsBetterElsewhere) {
  for (uint64_t seed = 1000; seed < 1050; ++seed) {
    const Problem p = random_problem(seed, 500, 4.0);
    const std::vector<float> counts = solve(p);
    double least_giver = 1e30, best_taker = 0;
    for (size_t i = 0; i < counts.size(); ++i) {
      if (p.rates[i] == 0.0f) continue;
      const double gain = double(p.rates[i]) / double(counts[i]);
      if (counts[i] > p.bounds[i].minimum) least_giver = std::min(least_giver, gain);
      if (counts[i] < p.bounds[i].maximum) best_taker = std::max(best_taker, gain);
    }
    EXPECT_LE(best_taker, least_giver * 1.001) << "replay with random_problem(" << seed << ")";
  }
}

// At Neyman's optimum, no shift of samples between pixels lowers the sum of variance / n.
TEST(ShareSamples, PerturbationsRaiseTheError) {
  for (uint64_t seed = 2000; seed < 2020; ++seed) {
    const Problem p = random_problem(seed, 300, 2.0);
    const std::vector<float> counts = solve(p);
    const auto error = [&](size_t i, double n) {
      return double(p.rates[i]) * double(p.rates[i]) / std::max(n, 1e-9);
    };
    TestRandom random(seed, 1);
    for (int trial = 0; trial < 2000; ++trial) {
      const size_t i = random.bits() % counts.size(), j = random.bits() % counts.size();
      if (i == j) continue;
      const double room = std::min(double(counts[i] - p.bounds[i].minimum),
                                   double(p.bounds[j].maximum - counts[j]));
      const double moved = room * random.next_double();
      const double before = error(i, double(counts[i])) + error(j, double(counts[j]));
      const double after =
          error(i, double(counts[i]) - moved) + error(j, double(counts[j]) + moved);
      // To first order, a shift between pixels with equal gains changes nothing. The tolerance
      // allows for float rounding and for the bisection's thousandth.
      ASSERT_GE(after, before * (1 - 1e-6)) << "seed " << seed << ", from " << i << " to " << j;
    }
  }
}

TEST(ShareSamples, AgainstEverySplitOfASmallBudget) {
  // Tries all integer splits of 60 samples and sums rate^2 / n. The best split is 36, 18 and 6,
  // which is in the ratio of the rates.
  const Problem p = {{6, 3, 1}, {{0, 100}, {0, 100}, {0, 100}}, 60};
  double best = 1e30;
  std::array<int, 3> split{};
  for (int a = 1; a < 59; ++a) {
    for (int b = 1; a + b < 60; ++b) {
      const double error = 36.0 / a + 9.0 / b + 1.0 / (60 - a - b);
      if (error < best) {
        best = error;
        split = {a, b, 60 - a - b};
      }
    }
  }
  EXPECT_EQ(split, (std::array{36, 18, 6}));
  const std::vector<float> counts = solve(p);
  for (size_t i = 0; i < 3; ++i) EXPECT_NEAR(counts[i], float(split[i]), 0.1f);
}

TEST(ShareSamples, AllAtTheirMostOrLeast) {
  Problem p = random_problem(1, 5000, 6.0);
  for (float& rate : p.rates) rate = std::max(rate, 1e-3f);
  for (const double total : {1e12, std::numeric_limits<double>::infinity()}) {
    p.total = total;
    const std::vector<float> counts = solve(p);
    for (size_t i = 0; i < counts.size(); ++i) ASSERT_EQ(counts[i], p.bounds[i].maximum);
  }
  for (const double total : {0.0, -1e12}) {
    p.total = total;
    const std::vector<float> counts = solve(p);
    for (size_t i = 0; i < counts.size(); ++i) {
      ASSERT_NEAR(counts[i], p.bounds[i].minimum, 0.01f) << "least " << p.bounds[i].minimum;
    }
  }
}

TEST(ShareSamples, ARateOfZeroStaysAtItsLeast) {
  const Problem p = {{0, 1, 0, 1}, {{8, 100}, {8, 100}, {0, 100}, {16, 100}}, 100};
  const std::vector<float> counts = solve(p);
  EXPECT_EQ(counts[0], 8.0f);
  EXPECT_EQ(counts[2], 0.0f);
  EXPECT_NEAR(counts[1], 46.0f, 0.1f);
  EXPECT_NEAR(counts[3], 46.0f, 0.1f);
  const std::vector<float> none = solve({{0, 0}, {{8, 100}, {4, 100}}, 100});
  EXPECT_EQ(none, (std::vector<float>{8, 4}));
  EXPECT_TRUE(solve({}).empty());
}

// The rates span 20 decades, as with a firefly next to a nearly black wall, and then 40 decades.
TEST(ShareSamples, HugeRangesOfRates) {
  for (const double decades : {20.0, 40.0}) {
    for (uint64_t seed = 3000; seed < 3030; ++seed) {
      SCOPED_TRACE("replay with random_problem(" + std::to_string(seed) + ", 777, " +
                   std::to_string(decades) + ")");
      const Problem p = random_problem(seed, 777, decades);
      const std::vector<float> counts = solve(p);
      EXPECT_NEAR(sum_of(counts), p.total, 1e-3 * p.total);
      for (size_t i = 0; i < counts.size(); ++i) {
        ASSERT_GE(counts[i], p.bounds[i].minimum);
        ASSERT_LE(counts[i], p.bounds[i].maximum);
      }
    }
  }
}

// The rates scale with the light of the frame, but the shares do not.
TEST(ShareSamples, AFactorOfAllRatesChangesNothing) {
  Problem p = random_problem(3100, 777, 6.0);
  for (const auto share : {&allocate_samples, &allocate_steps}) {
    std::vector<float> reference, counts;
    share(p.rates, p.bounds, p.total, &reference);
    for (int exponent = -20; exponent <= 20; ++exponent) {
      std::vector<float> rates = p.rates;
      for (float& rate : rates) rate = std::ldexp(rate, exponent);
      share(rates, p.bounds, p.total, &counts);
      for (size_t i = 0; i < counts.size(); ++i) {
        ASSERT_NEAR(counts[i], reference[i], 1e-3f * reference[i]) << exponent;
      }
    }
  }
}

// A pixel with a NaN rate gets its minimum, and the others get the rest.
TEST(ShareSamples, NonFiniteRates) {
  for (const auto share : {&allocate_samples, &allocate_steps}) {
    for (const float rate : {std::nanf(""), -std::nanf("")}) {
      const std::vector<float> rates = {1.0f, rate, 3.0f, rate};
      const std::vector<SampleBounds> bounds(4, {8, 4096});
      std::vector<float> counts;
      share(rates, bounds, 1000.0, &counts);
      EXPECT_EQ(counts[1], 8.0f);
      EXPECT_EQ(counts[3], 8.0f);
      EXPECT_LE(sum_of(counts), 1001.0);
      EXPECT_GE(sum_of(counts), 650.0);
    }
  }
}

TEST(ShareSamples, AnyThreads) {
  const Problem p = random_problem(4000, 100'003, 6.0);
  const std::vector<float> reference = solve(p);
  for (const int threads : {1, 2, 7}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, size_t(threads));
    tbb::task_arena arena(threads);
    arena.execute([&] { EXPECT_EQ(solve(p), reference) << threads << " threads"; });
  }
}

TEST(RoundCount, KeepsTheExpectation) {
  constexpr int kDraws = 4000;
  for (const uint32_t step : {8u, 16u}) {
    for (const uint32_t have : {0u, 1u, 4u, 7u, 8u, 16u, 100u, 1023u}) {
      for (const float more : {0.01f, 0.7f, 3.0f, 8.0f, 11.5f, 16.0f, 333.25f}) {
        const float wanted = float(have) + more;
        double sum = 0;
        for (int k = 0; k < kDraws; ++k) {
          const float u = (float(k) + 0.5f) / kDraws;
          const uint32_t count = round_count(have, wanted, step, u);
          ASSERT_TRUE(count == have || (count > have && count % step == 0)) << count;
          ASSERT_LT(std::abs(float(count) - wanted), float(step));
          sum += count;
        }
        // The draws are evenly spaced, so the mean is off by at most half a spacing.
        EXPECT_NEAR(sum / kDraws, double(wanted), double(step) / kDraws + 1e-6 * double(wanted))
            << "have " << have << ", wanted " << wanted << ", step " << step;
      }
    }
  }
}

TEST(RoundCount, NoPixelLosesSamples) {
  for (const float wanted : {-1.0f, 0.0f, 5.0f, 12.0f, std::numeric_limits<float>::quiet_NaN()}) {
    for (const float u : {0.0f, 0.5f, 0.999f}) EXPECT_EQ(round_count(12, wanted, 8, u), 12u);
  }
}

// The rates span four decades, and the initial counts are 8 to 64.
Problem doublings(uint64_t seed, double samples) {
  Problem p;
  for (size_t i = 0; i < 5000; ++i) {
    TestRandom random(seed, i);
    p.rates.push_back(float(std::pow(10.0, 4 * random.next_double() - 2)));
    p.bounds.push_back({float(8u << random.bits() % 4), 65536.0f});
  }
  p.total = samples * 5000;
  return p;
}

bool is_step(float count) {
  const float power = std::exp2(std::floor(std::log2(count)));
  return count == power || count == 1.5f * power;
}

TEST(ShareSteps, CountsArePowersOfTwoAndHalfAgainWithinTheTotal) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    const Problem p = doublings(seed, 40.0 * double(seed));
    std::vector<float> counts;
    allocate_steps(p.rates, p.bounds, p.total, &counts);
    for (size_t i = 0; i < counts.size(); ++i) {
      ASSERT_TRUE(is_step(counts[i])) << counts[i];
      ASSERT_GE(counts[i], p.bounds[i].minimum);
      ASSERT_LE(counts[i], p.bounds[i].maximum);
    }
    // The totals are 200,000 to 4,000,000. One more step of the largest pixel takes up to 65536
    // samples.
    EXPECT_LE(sum_of(counts), p.total);
    EXPECT_GE(sum_of(counts), 0.99 * p.total - 65536) << seed;
  }
}

// The variance is rate^2 / n, so growing from n to m samples reduces it by rate^2 / (n m) per
// sample. No omitted step may be worth more than a chosen step, except that powers of two are
// preferred. A count grows from 1 to 1.5 if K rate is above 1.3, where the step is worth 1.3^2 /
// 1.5. It grows on to 2 if K rate is above 1.62, where the step is worth 1.62^2 / 3. The ratio of
// these two is the tolerance.
TEST(ShareSteps, NoOtherStepsAreWorthMore) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    const Problem p = doublings(seed, 40.0 * double(seed));
    std::vector<float> counts;
    allocate_steps(p.rates, p.bounds, p.total, &counts);
    double least_taken = 1e30, most_left = 0;
    for (size_t i = 0; i < counts.size(); ++i) {
      const double n = double(counts[i]), worth = square(double(p.rates[i]) / n);
      const bool power = std::has_single_bit(uint32_t(counts[i]));
      const double before = power ? 3.0 / 4 : 2.0 / 3, after = power ? 3.0 / 2 : 4.0 / 3;
      if (counts[i] > p.bounds[i].minimum) least_taken = std::min(least_taken, worth / before);
      if (counts[i] < p.bounds[i].maximum) most_left = std::max(most_left, worth / after);
    }
    EXPECT_GT(least_taken, (1.62 * 1.62 / 3) / (1.3 * 1.3 / 1.5) * 0.999 * most_left) << seed;
  }
}

// A damaged state may contain such rates. The search must end, and every pixel must be within its
// bounds.
TEST(ShareSteps, NonFiniteRates) {
  constexpr float kInf = std::numeric_limits<float>::infinity();
  for (const float rate : {kInf, std::numeric_limits<float>::max(), std::nanf("")}) {
    const std::vector<float> rates = {1.0f, rate, 3.0f};
    const std::vector<SampleBounds> bounds(3, {8, 0x1p24f});
    std::vector<float> counts;
    allocate_steps(rates, bounds, 1000.0, &counts);
    for (const float count : counts) EXPECT_TRUE(count >= 8 && count <= 0x1p24f) << rate;
  }
}

TEST(ShareSteps, BoundsThatSettleEverything) {
  const std::vector<float> rates = {1.0f, 0.0f, 3.0f};
  const std::vector<SampleBounds> bounds = {{8, 100}, {8, 100}, {32, 20}};
  std::vector<float> counts;
  allocate_steps(rates, bounds, 0.0, &counts);
  EXPECT_EQ(counts, (std::vector<float>{8, 8, 32}));
  allocate_steps(rates, bounds, 1e18, &counts);
  EXPECT_EQ(counts, (std::vector<float>{100, 8, 32}));
  allocate_steps(std::vector<float>(3, 0.0f), bounds, 1e6, &counts);
  EXPECT_EQ(counts, (std::vector<float>{8, 8, 32}));
}

}  // namespace
}  // namespace emberline
