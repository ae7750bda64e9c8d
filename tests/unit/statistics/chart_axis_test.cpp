// Axes have round ticks inside the range, for any values.
#include "renderer/statistics/chart_axis.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace emberline {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

std::vector<std::string> labels(const AxisRange& range, int wanted = 6) {
  std::vector<std::string> list;
  for (const AxisTick& tick : range.ticks(wanted)) list.push_back(tick.label);
  return list;
}

using Words = std::vector<std::string>;

TEST(ChartAxis, NiceStepIsOneTwoOrFive) {
  EXPECT_DOUBLE_EQ(nice_step(10, 10), 1);
  EXPECT_DOUBLE_EQ(nice_step(10, 9), 2);
  EXPECT_DOUBLE_EQ(nice_step(10, 4), 5);
  EXPECT_DOUBLE_EQ(nice_step(10, 1), 10);
  EXPECT_DOUBLE_EQ(nice_step(0.7, 7), 0.1);
  EXPECT_DOUBLE_EQ(nice_step(0.71, 7), 0.2);
  EXPECT_DOUBLE_EQ(nice_step(3e-9, 5), 1e-9);
}

TEST(ChartAxis, Labels) {
  EXPECT_EQ(tick_label(0.25, 0.05), "0.25");
  EXPECT_EQ(tick_label(0.3, 0.1), "0.3");
  EXPECT_EQ(tick_label(1500, 500), "1,500");
  EXPECT_EQ(tick_label(-2, 1), "-2");
  EXPECT_EQ(tick_label(1e-18, 0.1), "0");  // for example 3 x 0.1 - 0.3
  EXPECT_EQ(tick_label(1e-5, 1e-5), "10⁻⁵");
  EXPECT_EQ(tick_label(2e-5, 1e-5), "2×10⁻⁵");
  EXPECT_EQ(tick_label(2.5e7, 5e6), "2.5×10⁷");
  EXPECT_EQ(tick_label(1e12, 1e12), "10¹²");
}

TEST(ChartAxis, LinearBeginsAndEndsAtTicks) {
  const AxisRange range(AxisScale::kLinear, std::vector{0.13, 0.91});
  EXPECT_DOUBLE_EQ(range.min(), 0.0);
  EXPECT_DOUBLE_EQ(range.max(), 1.0);
  EXPECT_EQ(labels(range), (Words{"0", "0.2", "0.4", "0.6", "0.8", "1.0"}));
  EXPECT_DOUBLE_EQ(range.position(0.25), 0.25);
}

TEST(ChartAxis, LogTicksArePowersOfTenAndTheirPartsWhereFew) {
  EXPECT_EQ(labels(AxisRange(AxisScale::kLog, std::vector{1.0, 50.0})),
            (Words{"1", "2", "5", "10", "20", "50"}));
  Words powers;
  for (const AxisTick& tick : AxisRange(AxisScale::kLog, std::vector{2e-6, 300.0}).ticks()) {
    if (!tick.label.empty()) powers.push_back(tick.label);
  }
  EXPECT_EQ(powers, (Words{"10⁻⁶", "0.0001", "0.01", "1", "100"}));
  // A range too short for powers of ten gets linear ticks.
  EXPECT_EQ(labels(AxisRange(AxisScale::kLog, std::vector{3.0, 4.0})),
            (Words{"3.0", "3.2", "3.4", "3.6", "3.8", "4.0"}));
}

TEST(ChartAxis, LogPlacesFactorsEvenly) {
  const AxisRange range(AxisScale::kLog, std::vector{1.0, 10000.0});
  EXPECT_NEAR(range.position(100) - range.position(10),
              range.position(10000) - range.position(1000), 1e-12);
  EXPECT_NEAR(range.position(100), 0.5, 1e-12);
  EXPECT_GT(range.position(1), 0.0);
  EXPECT_LT(range.position(10000), 1.0);
}

TEST(ChartAxis, RejectsInvalidRanges) {
  for (const AxisScale scale : {AxisScale::kLinear, AxisScale::kLog}) {
    EXPECT_FALSE(AxisRange::drawable(scale, kNan));
    EXPECT_FALSE(AxisRange::drawable(scale, kInfinity));
    EXPECT_FALSE(AxisRange::drawable(scale, 1e200));
    EXPECT_TRUE(AxisRange::drawable(scale, 3.0));
  }
  EXPECT_TRUE(AxisRange::drawable(AxisScale::kLinear, 0.0));
  EXPECT_FALSE(AxisRange::drawable(AxisScale::kLog, 0.0));
  EXPECT_FALSE(AxisRange::drawable(AxisScale::kLog, -1.0));
}

TEST(ChartAxis, NoValuesAndOneValue) {
  const AxisRange none(AxisScale::kLinear, std::vector{kNan});
  EXPECT_EQ(none.min(), 0);
  EXPECT_EQ(none.max(), 1);
  const AxisRange none_log(AxisScale::kLog, std::vector{0.0, -5.0, kInfinity});
  EXPECT_GT(none_log.min(), 0.5);
  EXPECT_LT(none_log.max(), 20);
  for (const double v : {0.0, 5.0, -3.0, 1e-30, 1e90}) {
    const AxisRange range(AxisScale::kLinear, std::vector{v});
    EXPECT_GE(range.position(v), 0.0) << v;
    EXPECT_LE(range.position(v), 1.0) << v;
    EXPECT_GE(range.ticks().size(), 2u) << v;
  }
  const AxisRange zero(AxisScale::kLinear, std::vector{4.0}, true);
  EXPECT_EQ(zero.min(), 0);
}

// For any range, ticks ascend, lie inside, differ in label, and are neither too few nor too many.
TEST(ChartAxis, TicksOfRandomRanges) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> exponent(-30, 30), unit(0, 1);
  for (int i = 0; i < 4000; ++i) {
    const AxisScale scale = i % 2 ? AxisScale::kLog : AxisScale::kLinear;
    const double a = std::pow(10, exponent(random));
    double b = i % 3 ? a * (1 + unit(random)) : std::pow(10, exponent(random));
    if (scale == AxisScale::kLinear && i % 4 == 0) b = -b;
    const AxisRange range(scale, std::vector{a, b});
    const int wanted = 2 + i % 7;
    const std::vector<AxisTick> ticks = range.ticks(wanted);
    Words labelled;
    for (size_t t = 0; t < ticks.size(); ++t) {
      EXPECT_GT(ticks[t].value, range.min() - 1e-6 * (range.max() - range.min()));
      EXPECT_LT(ticks[t].value, range.max() + 1e-6 * (range.max() - range.min()));
      EXPECT_GT(ticks[t].value, t > 0 ? ticks[t - 1].value : -1e99);
      if (!ticks[t].label.empty()) labelled.push_back(ticks[t].label);
    }
    EXPECT_GE(labelled.size(), 1u) << a << " " << b << " " << wanted;
    EXPECT_LE(labelled.size(), size_t(std::max(wanted, 3)) + 2) << a << " " << b << " " << wanted;
    for (size_t t = 1; t < labelled.size(); ++t) EXPECT_NE(labelled[t], labelled[t - 1]);
    for (const double v : {a, b}) {
      EXPECT_GE(range.position(v), -1e-9);
      EXPECT_LE(range.position(v), 1 + 1e-9);
    }
  }
}

}  // namespace
}  // namespace emberline
