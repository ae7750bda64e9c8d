// Tests the scales of heatmaps: automatic ranges, positions along the bar, and round numbers.
#include "renderer/statistics/value_scale.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace emberline {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

Plane row(std::vector<float> values) {
  Plane plane{int(values.size()), 1, {}};
  plane.values = std::move(values);
  return plane;
}

std::string labels(const ValueScale& scale, int max, double factor = 1) {
  std::string text;
  for (const AxisTick& tick : scale.ticks(max, factor)) text += tick.label + " ";
  return text;
}

TEST(PlaneStatistics, IgnoreNonFiniteValues) {
  const PlaneStatistics s = plane_statistics(row({3, kNan, 0, -1, kInf, -kInf, 6}));
  EXPECT_EQ(s.values, 4u);
  EXPECT_EQ(s.no_value, 3u);
  EXPECT_EQ(s.nonzero, 3u);
  EXPECT_EQ(s.minimum, -1);
  EXPECT_EQ(s.mean, 2);
  EXPECT_EQ(s.maximum, 6);
  EXPECT_DOUBLE_EQ(s.rms, std::sqrt(46.0 / 4));
  EXPECT_FALSE(s.constant());
}

TEST(PlaneStatistics, OfOneValueIsThatValue) {
  const PlaneStatistics s = plane_statistics({100, 100, std::vector<float>(10000, 0.1f)});
  EXPECT_TRUE(s.constant());
  EXPECT_EQ(s.mean, double(0.1f));
  EXPECT_EQ(s.rms, double(0.1f));
  EXPECT_FALSE(plane_statistics(row({kNan})).constant());
  EXPECT_EQ(plane_statistics(row({kNan})).mean, 0);
}

TEST(AutomaticRange, LeavesOutTheGreatestTwoPercent) {
  std::vector<float> values(2000, 0.0f);
  for (size_t i = 0; i < 1000; ++i) values[2 * i] = float(i + 1);
  for (size_t i = 0; i < 50; ++i) values[2 * i] = kInf;  // 950 non-zero values: 51 to 1000
  const ValueRange range = automatic_range(row(values), false);
  EXPECT_EQ(range.min, 0);
  EXPECT_EQ(range.max, 981);
  EXPECT_EQ(automatic_range(row(values), false, 0.5).max, 525);
  EXPECT_EQ(automatic_range(row({1, 2, 3}), false).max, 3);
}

TEST(AutomaticRange, FewNonzeroPixels) {
  std::vector<float> values(10000, 0.0f);
  values[77] = 3;
  EXPECT_EQ(automatic_range(row(values), false).max, 3);
}

TEST(AutomaticRange, NegativeValues) {
  const ValueRange mixed = automatic_range(row({-4, 0, 2}), false);
  EXPECT_EQ(mixed.min, -4);
  EXPECT_EQ(mixed.max, 2);
  const ValueRange negative = automatic_range(row({-4, -4, 0}), false);
  EXPECT_EQ(negative.min, -4);
  EXPECT_EQ(negative.max, 0);
}

TEST(AutomaticRange, AConstantIsInTheMiddle) {
  for (const bool logarithmic : {false, true}) {
    const ValueRange range = automatic_range(row({64, 64, kNan}), logarithmic);
    EXPECT_DOUBLE_EQ(ValueScale(range, logarithmic).position(64), 0.5);
  }
  EXPECT_EQ(ValueScale(automatic_range(row({0, 0}), false), false).position(0), 0);
  EXPECT_DOUBLE_EQ(ValueScale(automatic_range(row({-3, -3}), false), false).position(-3), 0.5);
}

TEST(AutomaticRange, LogarithmicIsAlwaysAboveZero) {
  const ValueRange range = automatic_range(row({0, -1, 0.5f, 8, kNan}), true);
  EXPECT_EQ(range.min, 0.5);
  EXPECT_EQ(range.max, 8);
  std::vector<float> values(1000, 10.0f);
  for (size_t i = 0; i < 5; ++i) values[i] = 1e-9f;  // half a per cent of outliers
  values[999] = 20;
  EXPECT_EQ(automatic_range(row(values), true).min, double(1e-9f));
  values[4] = 10;
  EXPECT_EQ(automatic_range(row(values), true).min, 10);
  for (const Plane& plane : {row({0, 0}), row({-1, 0}), row({kNan}), row({5, 0}), row({-2})}) {
    const ValueRange any = automatic_range(plane, true);
    EXPECT_GT(any.min, 0);
    EXPECT_LT(any.min, any.max);
  }
}

TEST(ValueScale, PlacesAlongTheBar) {
  const ValueScale linear({2, 10}, false);
  EXPECT_EQ(linear.position(2), 0);
  EXPECT_EQ(linear.position(6), 0.5);
  EXPECT_EQ(linear.position(14), 1.5);
  EXPECT_TRUE(std::isnan(linear.position(INFINITY)));
  EXPECT_TRUE(std::isnan(linear.position(NAN)));
  const ValueScale decades({0.01, 100}, true);
  EXPECT_DOUBLE_EQ(decades.position(1), 0.5);
  EXPECT_DOUBLE_EQ(decades.position(1000), 1.25);
  EXPECT_EQ(decades.position(0), -INFINITY);
  EXPECT_EQ(decades.position(-5), -INFINITY);
  EXPECT_TRUE(std::isnan(decades.position(NAN)));
}

TEST(ValueScale, TicksAreRoundNumbers) {
  EXPECT_EQ(labels(ValueScale({0, 112}, false), 8), "0 20 40 60 80 100 ");
  EXPECT_EQ(labels(ValueScale({0, 0.32}, false), 5), "0 0.1 0.2 0.3 ");
  EXPECT_EQ(labels(ValueScale({0, 0.001}, false), 6), "0 0.0002 0.0004 0.0006 0.0008 0.0010 ");
  EXPECT_EQ(labels(ValueScale({-5, 5}, false), 3), "-5 0 5 ");
  EXPECT_EQ(labels(ValueScale({1000.1, 1000.4}, false), 4), "1,000.1 1,000.2 1,000.3 1,000.4 ");
  EXPECT_EQ(labels(ValueScale({0, 0.003}, false), 4, 1e3), "0 1 2 3 ");
  EXPECT_EQ(labels(ValueScale({0, 4e7}, false), 3), "0 2×10⁷ 4×10⁷ ");
}

TEST(ValueScale, LogarithmicTicksAreDecadesWithStepsBetweenFewOfThem) {
  EXPECT_EQ(labels(ValueScale({1, 1000}, true), 5), "1 10 100 1,000 ");
  EXPECT_EQ(labels(ValueScale({0.5, 20}, true), 8), "0.5 1 2 5 10 20 ");
  EXPECT_EQ(labels(ValueScale({1e-9, 1}, true), 4), "10⁻⁹ 10⁻⁶ 0.001 1 ");
  EXPECT_EQ(labels(ValueScale({6, 9}, true), 4), "6 7 8 9 ");
}

// For any range, the ticks are inside it and ascending. There is at least one, and no more than
// requested.
TEST(ValueScale, TicksOfAnyRange) {
  for (const bool logarithmic : {false, true}) {
    for (const double min : {1e-30, 1e-6, 0.37, 1.0, 123.4, 9.99e8}) {
      for (const double factor : {1.0001, 1.5, 3.0, 10.0, 12345.0, 1e12}) {
        const ValueScale scale({min, min * factor}, logarithmic);
        for (const int max : {2, 3, 7, 40}) {
          const std::vector<AxisTick> ticks = scale.ticks(max);
          EXPECT_LE(ticks.size(), size_t(max)) << min << " x " << factor;
          EXPECT_GE(ticks.size(), 1u) << min << " x " << factor << ", " << max;
          for (size_t i = 0; i < ticks.size(); ++i) {
            EXPECT_GE(scale.position(ticks[i].value), -1e-6);
            EXPECT_LE(scale.position(ticks[i].value), 1 + 1e-6);
            EXPECT_LT(i > 0 ? ticks[i - 1].value : -INFINITY, ticks[i].value);
          }
        }
      }
    }
  }
}

TEST(NumberText, FourDigits) {
  EXPECT_EQ(number_text(64), "64");
  EXPECT_EQ(number_text(63.9876), "63.99");
  EXPECT_EQ(number_text(0.031234), "0.03123");
  EXPECT_EQ(number_text(123456), "123,456");
  EXPECT_EQ(number_text(96820.4), "96,820");
  EXPECT_EQ(number_text(999.96), "1,000");
  EXPECT_EQ(number_text(0), "0");
  EXPECT_EQ(number_text(-0.0), "0");
  EXPECT_EQ(number_text(-0.0123), "-0.0123");
  EXPECT_EQ(number_text(1.5e-7), "1.5×10⁻⁷");
  EXPECT_EQ(number_text(9.99996e-6), "10⁻⁵");
  EXPECT_EQ(number_text(-12345678), "-1.235×10⁷");
}

TEST(DisplayUnit, SecondsBySize) {
  EXPECT_EQ(display_unit("s", 2).name, "s");
  EXPECT_EQ(display_unit("s", 0.5).name, "ms");
  EXPECT_EQ(display_unit("s", 0.5).factor, 1e3);
  EXPECT_EQ(display_unit("s", 2e-5).name, "µs");
  EXPECT_EQ(display_unit("s", 2e-8).name, "ns");
  EXPECT_EQ(display_unit("s", 0).name, "s");
  EXPECT_EQ(display_unit("", 1e-5).factor, 1);
}

}  // namespace
}  // namespace emberline
