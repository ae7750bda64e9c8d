// Tests the building blocks of the environment: the fast angle and the cumulative sums.
#include "renderer/lights/fixed_cdf.h"

#include <gtest/gtest.h>

#include <vector>

#include "renderer/core/fast_angle.h"
#include "support/chi_square.h"

namespace emberline {
namespace {

using test::TestRandom;

TEST(FastAngle, IsWithinItsError) {
  double worst = 0;
  for (uint64_t draw = 0; draw < 1'000'000; ++draw) {
    TestRandom random(3, draw);
    const float scale = std::ldexp(1.0f, int(random.bits() % 60) - 30);
    const float y = (2 * random.next() - 1) * scale, x = (2 * random.next() - 1);
    worst = std::max(worst, std::abs(double(fast_atan2(y, x)) - std::atan2(double(y), double(x))));
  }
  EXPECT_LT(worst, 4e-7);
  EXPECT_EQ(fast_atan2(0.0f, 0.0f), 0.0f);
  EXPECT_NEAR(fast_atan2(0.0f, -1.0f), kPi, 1e-6f);
  EXPECT_NEAR(fast_atan2(-0.0f, -1.0f), -kPi, 1e-6f);
  EXPECT_NEAR(fast_atan2(1.0f, 0.0f), kPi / 2, 1e-6f);
  EXPECT_NEAR(fast_atan2(-1e-30f, 1e-30f), -kPi / 4, 1e-6f);
}

TEST(FixedCdf, ChoosesAsASearchFromTheLeftWould) {
  const std::vector<std::vector<double>> cases = {{1.0},        {0, 0, 5},         {5, 0, 0},
                                                  {0, 3, 0, 0}, {1e-30, 1, 1e-30}, {1, 1e12, 1}};
  std::vector<std::vector<double>> all = cases;
  std::vector<double> random_weights, one_big(1000, 1e-3);
  for (uint64_t i = 0; i < 777; ++i) {
    TestRandom random(8, i);
    random_weights.push_back(random.next() < 0.3f ? 0.0 : std::pow(random.next_double(), 20));
  }
  one_big[500] = 1e9;
  all.push_back(random_weights);
  all.push_back(one_big);
  for (const std::vector<double>& weights : all) {
    std::vector<uint32_t> sums(weights.size() + 1), guide(guide_words(weights.size()));
    build_fixed_cdf(weights, sums.data(), guide.data());
    ASSERT_EQ(sums.front(), 0u);
    ASSERT_EQ(sums.back(), kCdfTotal);
    double total = 0;
    for (double w : weights) total += w;
    for (size_t i = 0; i < weights.size(); ++i) {
      ASSERT_GE(sums[i + 1], sums[i]);
      const double p = double(sums[i + 1] - sums[i]) / kCdfTotal;
      ASSERT_EQ(p > 0, weights[i] > 0) << i;  // zero exactly where the weight is zero
      ASSERT_NEAR(p, weights[i] / total, double(weights.size()) * 0x1p-32) << i;
    }
    for (uint64_t draw = 0; draw < 3000; ++draw) {
      const float u = draw == 0 ? 0.0f : draw == 1 ? kOneMinusEpsilon : TestRandom(4, draw).next();
      const CdfChoice choice =
          choose_entry(sums.data(), guide.data(), guide_bits(weights.size()), u);
      const double x = double(u) * kCdfTotal;
      size_t naive = 0;
      while (double(sums[naive + 1]) <= x) ++naive;
      ASSERT_EQ(choice.index, naive) << u;
      ASSERT_GE(choice.remainder, 0.0f);
      ASSERT_LT(choice.remainder, 1.0f);
      ASSERT_NEAR(double(sums[naive]) + choice.remainder * double(sums[naive + 1] - sums[naive]), x,
                  1e-7 * kCdfTotal);
    }
  }
}

}  // namespace
}  // namespace emberline
