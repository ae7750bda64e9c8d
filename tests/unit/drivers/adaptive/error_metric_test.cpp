// Compares the display curve and the weights of errors with their formulas.
#include "renderer/drivers/adaptive/error_estimator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "renderer/core/errors.h"
#include "support/srgb.h"

namespace emberline {
namespace {

// Calls `body` for every 997th float from 1e-6 to 2.
template <typename Body>
void for_each_brightness(const Body& body) {
  const auto last = std::bit_cast<uint32_t>(2.0f);
  for (auto bits = std::bit_cast<uint32_t>(1e-6f); bits < last; bits += 997) {
    body(std::bit_cast<float>(bits));
  }
}

TEST(DisplayValue, MatchesTheStandardCurve) {
  double worst = 0;
  for_each_brightness([&](float x) {
    worst = std::max(worst, std::abs(double(display_value(x)) - test::srgb(double(x))));
  });
  EXPECT_LT(worst, 1e-6);
}

TEST(DisplayValue, NeverFalls) {
  float before = 0.0f;
  for_each_brightness([&](float x) {
    ASSERT_GE(display_value(x), before) << x;
    before = display_value(x);
  });
  EXPECT_EQ(before, 1.0f);
}

TEST(DisplayValue, ClipsToTheDisplayRange) {
  EXPECT_EQ(display_value(-1.0f), 0.0f);
  EXPECT_EQ(display_value(-INFINITY), 0.0f);
  EXPECT_EQ(display_value(0.0f), 0.0f);
  EXPECT_EQ(display_value(NAN), 0.0f);
  EXPECT_EQ(display_value(1.0f), 1.0f);
  EXPECT_EQ(display_value(1e30f), 1.0f);
  EXPECT_EQ(display_value(INFINITY), 1.0f);
  EXPECT_GT(display_value(1e-30f), 0.0f);
}

// The weight is the squared slope of the curve over mean +- deviation, by the exact formula.
TEST(ErrorWeight, DisplayIsTheSquaredSlope) {
  for (const double mean : {0.001, 0.01, 0.1, 0.3, 0.7, 0.95, 1.05}) {
    for (const double deviation : {0.01, 0.03, 0.1, 0.5}) {
      const double slope =
          (test::srgb(mean + deviation) - test::srgb(mean - deviation)) / (2 * deviation);
      // Both values of the curve are known to 1e-6, and their difference is divided by the step.
      EXPECT_NEAR(std::sqrt(display_error_weight(float(mean), float(deviation))),
                  std::max(slope, double(kMinDisplaySlope)), 1e-6 / deviation)
          << mean << " +- " << deviation;
    }
  }
  // A deviation below .001 is raised to .001. Half of the interval below the mean is black.
  EXPECT_NEAR(display_error_weight(5e-4f, 1e-7f), 0.75 * 12.92 * 0.75 * 12.92, 1e-3);
}

TEST(ErrorWeight, ClippedWhiteCountsLittleButCounts) {
  const float floor = kMinDisplaySlope * kMinDisplaySlope;
  const auto weight = [](float mean, float deviation) {
    return display_error_weight(mean, deviation);
  };
  EXPECT_EQ(weight(5.0f, 1.0f), floor);
  EXPECT_EQ(weight(INFINITY, 1.0f), floor);
  EXPECT_EQ(weight(-5.0f, 1.0f), floor);
  EXPECT_EQ(weight(NAN, 1.0f), floor);
  EXPECT_GT(weight(5.0f, 4.9f), floor);  // the noise may fall below white
}

// A value in [0, 1] has a variance of at most 1/4, however bright the samples are.
TEST(ErrorWeight, NoErrorIsLargerThanTheDisplayCanShow) {
  for (const float mean : {0.0f, 0.5f, 5.0f, 3000.0f}) {
    for (const float deviation : {0.01f, 1.0f, 30.0f, 1000.0f, 1e9f, 1e15f}) {
      const double weight = double(display_error_weight(mean, deviation));
      EXPECT_GT(weight, 0.0) << mean << " +- " << deviation;
      EXPECT_LE(weight * double(deviation) * double(deviation), 0.2501)
          << mean << " +- " << deviation;
    }
  }
  EXPECT_GT(display_error_weight(0.5f, INFINITY), 0.0f);
}

}  // namespace
}  // namespace emberline
