// Tests the error estimators on synthetic pixels: their common contract, and each of them against
// values computed by hand. error_estimator_statistics_test.cpp tests their calibration.
#include "renderer/core/rect.h"
#include "renderer/drivers/adaptive/error_estimator.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <string>

#include "renderer/core/errors.h"
#include "renderer/drivers/adaptive/chi_square_estimator.h"
#include "renderer/drivers/adaptive/contrast_estimator.h"
#include "renderer/drivers/adaptive/dammertz_estimator.h"
#include "renderer/drivers/adaptive/kajiya_estimator.h"
#include "renderer/drivers/adaptive/painter_sloan_estimator.h"
#include "unit/synthetic_pixels.h"

namespace emberline {
namespace {

using test::constant_pixels;
using test::drawn_pixels;
using test::TestRandom;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kUnfinished = 1e3f;  // above any threshold that a user would choose

using Estimator = decltype(EstimatorEntry::estimate);

std::vector<float> errors(Estimator estimate, const PixelStatistics& pixels,
                          float threshold = 0.0f) {
  ErrorMap map;
  estimate(pixels, {.threshold = threshold}, &map);
  EXPECT_EQ(map.error.size(), pixels.size());
  return map.error;
}

std::string test_name(const ::testing::TestParamInfo<EstimatorEntry>& info) {
  std::string name(info.param.name);
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

// ---- common contract ---------------------------------------------------------------------------

class EveryEstimator : public ::testing::TestWithParam<EstimatorEntry> {
 protected:
  std::vector<float> estimate(const PixelStatistics& pixels, float threshold = 0.01f) const {
    return errors(GetParam().estimate, pixels, threshold);
  }
};

// Returns planes whose elements are chosen at random from `values`, independently for each pixel.
PixelStatistics planes_of(int width, int height, uint64_t seed, const std::vector<float>& values) {
  PixelStatistics pixels = constant_pixels(width, height, 0.0f, 0.0f);
  for (size_t i = 0; i < pixels.size(); ++i) {
    TestRandom random(seed, i);
    const auto value = [&] { return values[random.bits() % values.size()]; };
    for (auto* plane : {&pixels.count, &pixels.second_count, &pixels.cost}) (*plane)[i] = value();
    for (size_t c = 0; c < 3; ++c) {
      pixels.mean[c][i] = value();
      pixels.variance[c][i] = value();
      pixels.stream_difference[c][i] = value();
    }
  }
  return pixels;
}

TEST_P(EveryEstimator, HostileStatisticsGiveFiniteErrors) {
  const std::vector<float> values = {kNaN, kInfinity, -kInfinity, 0.0f,  1.0f,
                                     2.0f, 16.0f,     1e30f,      -5.0f, 1e-40f};
  for (const auto& [width, height] : {std::pair{0, 0}, {1, 1}, {1, 9}, {9, 1}, {61, 47}}) {
    for (const float threshold : {0.0f, 0.02f}) {
      for (const float error : estimate(planes_of(width, height, 5, values), threshold)) {
        ASSERT_TRUE(std::isfinite(error) && error >= 0.0f) << error;
      }
    }
  }
}

// A frame may have any scale of light. The errors and rates must be finite, and with the mse metric
// the rates scale with the light, so that samples go to the same pixels.
TEST_P(EveryEstimator, AFramesScaleMakesNoNumberANonNumber) {
  const auto scaled_frame = [](int exponent) {
    const double scale = std::ldexp(1.0, exponent);
    PixelStatistics pixels = drawn_pixels(40, 30, 16, 4, [&](TestRandom& random) {
      return scale * (0.2 + 0.1 * random.next_double());
    });
    for (size_t c = 0; c < 3; ++c) {  // a row without noise, like the sun's disc or a lamp
      for (size_t x = 0; x < 40; ++x) {
        pixels.mean[c][x] = float(scale);
        pixels.variance[c][x] = pixels.stream_difference[c][x] = 0.0f;
      }
    }
    return pixels;
  };
  for (const ErrorMetric metric :
       {ErrorMetric::kDisplay, ErrorMetric::kMse, ErrorMetric::kRelMse}) {
    ErrorMap reference;
    GetParam().estimate(scaled_frame(0), {.threshold = 0.01f, .allocation = metric}, &reference);
    for (int exponent = -20; exponent <= 20; ++exponent) {
      SCOPED_TRACE(exponent);
      ErrorMap map;
      GetParam().estimate(scaled_frame(exponent), {.threshold = 0.01f, .allocation = metric}, &map);
      for (const float error : map.error) ASSERT_TRUE(error >= 0.0f && error < 1e6f) << error;
      for (const float rate : map.deviation) ASSERT_TRUE(rate >= 0.0f && rate < 1e18f) << rate;
      if (metric != ErrorMetric::kMse) continue;
      for (size_t i = 0; i < map.deviation.size(); ++i) {
        const float expected = std::ldexp(reference.deviation[i], exponent);
        ASSERT_NEAR(map.deviation[i], expected, 1e-3f * expected) << i;
      }
    }
  }
}

TEST_P(EveryEstimator, ThreadsDoNotMatter) {
  const PixelStatistics pixels = drawn_pixels(
      173, 91, 16, 3, [](TestRandom& random) { return random.next_double() < 0.2 ? 1.0 : 0.1; });
  const std::vector<float> many = estimate(pixels);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(many, estimate(pixels));
}

TEST_P(EveryEstimator, ReplacesOldValuesOfTheMap) {
  const PixelStatistics pixels = drawn_pixels(
      40, 30, 16, 4, [](TestRandom& random) { return 0.2 + 0.1 * random.next_double(); });
  const EstimatorSettings settings = {.threshold = 0.01f};
  ErrorMap fresh, used;
  used.error.assign(7777, 123.0f);
  used.deviation.assign(7777, 123.0f);
  GetParam().estimate(pixels, settings, &fresh);
  GetParam().estimate(pixels, settings, &used);
  EXPECT_EQ(fresh.error, used.error);
  EXPECT_EQ(fresh.deviation, used.deviation);
  EXPECT_TRUE(GetParam().batch == 0 || fresh.deviation.empty());
}

INSTANTIATE_TEST_SUITE_P(Table, EveryEstimator, ::testing::ValuesIn(estimator_table()), test_name);

// The historical estimators test one pixel or block against a threshold and request a batch if the
// test fails.
std::vector<EstimatorEntry> historical_estimators() {
  std::vector<EstimatorEntry> result;
  for (const EstimatorEntry& entry : estimator_table()) {
    if (entry.batch > 0) result.push_back(entry);
  }
  return result;
}

class HistoricalEstimator : public EveryEstimator {};

TEST_P(HistoricalEstimator, PixelsWithoutSamplesAreUnfinished) {
  PixelStatistics pixels = constant_pixels(8, 4, 0.5f, 16.0f);
  pixels.count[9] = pixels.second_count[9] = 0.0f;
  pixels.count[20] = 1.0f;
  pixels.second_count[20] = 0.0f;
  const std::vector<float> map = estimate(pixels);
  for (size_t i = 0; i < map.size(); ++i) {
    if (i == 9 || i == 20) {
      EXPECT_GT(map[i], kUnfinished) << i;
    } else {
      EXPECT_EQ(map[i], 0.0f) << i;
    }
  }
}

TEST_P(HistoricalEstimator, ConstantsAreFinished) {
  for (const float value : {0.0f, 1e-6f, 0.3f, 1.0f, 40.0f}) {
    for (const float n : {float(GetParam().first_samples), 1024.0f}) {
      for (const float threshold : {0.0f, 0.01f}) {
        for (const float error : estimate(constant_pixels(37, 11, value, n), threshold)) {
          ASSERT_EQ(error, 0.0f) << value << " " << n;
        }
      }
    }
  }
}

// A non-finite or huge value does not spread: pixels that are two away from it do not change.
TEST_P(HistoricalEstimator, BadPixelDoesNotAffectOthers) {
  for (const float bad : {kNaN, kInfinity, -kInfinity}) {
    PixelStatistics pixels = constant_pixels(9, 9, 0.5f, 16.0f);
    constexpr size_t kCentre = 4 * 9 + 4;
    for (size_t c = 0; c < 3; ++c) {
      pixels.mean[c][kCentre] = bad;
      pixels.variance[c][kCentre] = bad;
      pixels.stream_difference[c][kCentre] = bad;
    }
    const std::vector<float> map = estimate(pixels);
    for (int y = 0; y < 9; ++y) {
      for (int x = 0; x < 9; ++x) {
        if (std::abs(x - 4) > 1 || std::abs(y - 4) > 1) {
          EXPECT_EQ(map[size_t(9 * y + x)], 0.0f) << bad << " at " << x << "," << y;
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Table, HistoricalEstimator, ::testing::ValuesIn(historical_estimators()),
                         test_name);

TEST(EstimatorTable, Names) {
  std::set<std::string_view> names;
  for (const EstimatorEntry& entry : estimator_table()) {
    EXPECT_TRUE(names.insert(entry.name).second) << entry.name;
    EXPECT_EQ(&find_estimator(entry.name), &entry);
    EXPECT_GE(entry.first_samples, 2u);
    // The first samples must suffice for an estimate, and the second stream starts at 8 samples.
    EXPECT_TRUE(entry.streams == StreamCount::kOne || entry.first_samples >= 16) << entry.name;
  }
  try {
    find_estimator("kajia");
    FAIL() << "accepted an unknown name";
  } catch (const UsageError& error) {
    const std::string message = error.what();
    EXPECT_EQ(message.find("estimator: unknown estimator 'kajia' (did you mean 'kajiya'?)"), 0u)
        << message;
  }
}

// ---- values by hand ----------------------------------------------------------------------------

// The display curve is straight here. The weight of an error is the slope over .001 to each side,
// and half of the lower side is black.
constexpr float kDark = 5e-4f;
constexpr double kCurveSlope = 12.92, kDarkSlope = 0.75 * kCurveSlope;

// A dark pixel whose channels have the sample variances v, 2 v and 6 v, or 3 v on average.
PixelStatistics dark_pixel(float count, float variance) {
  PixelStatistics pixels = constant_pixels(1, 1, kDark, count);
  pixels.variance = {{{variance}, {2 * variance}, {6 * variance}}};
  return pixels;
}

TEST(ChiSquareEstimator, ByHand) {
  const Estimator estimator = estimate_chi_square;
  // The tabulated 5 % quantiles of chi-square are 2.16735 for 7 degrees and 7.26094 for 15 degrees.
  const double v = 1e-8;
  EXPECT_NEAR(errors(estimator, dark_pixel(8, float(v)))[0],
              kDarkSlope * std::sqrt(3 * v / 8 * 7 / 2.16735), 4e-3 * kDarkSlope * 1e-4);
  EXPECT_NEAR(errors(estimator, dark_pixel(16, float(v)))[0],
              kDarkSlope * std::sqrt(3 * v / 16 * 15 / 7.26094), 1e-3 * kDarkSlope * 1e-4);
  EXPECT_GT(errors(estimator, dark_pixel(7, float(v)))[0], kUnfinished);
}

TEST(PainterSloanEstimator, ByHand) {
  const Estimator estimator = estimate_painter_sloan;
  const double v = 1e-8;
  EXPECT_NEAR(errors(estimator, dark_pixel(8, float(v)))[0],
              kDarkSlope * 2.364624 * std::sqrt(3 * v / 8), 1e-6);
  EXPECT_NEAR(errors(estimator, dark_pixel(4, float(v)))[0],  // no neighbourhood here
              kDarkSlope * 3.182446 * std::sqrt(3 * v / 4), 1e-5);
}

// With few samples the estimate uses the neighbourhood. The means are k/4096, with 1/4096 in the
// centre.
TEST(PainterSloanEstimator, NeighbourhoodOfFewSamples) {
  const Estimator estimator = estimate_painter_sloan;
  constexpr float kUnit = 0x1p-12f;
  PixelStatistics pixels = constant_pixels(3, 3, kUnit, 4.0f);
  pixels.mean[0] = {9, 2, 9, 4, 1, 6, 9, 7, 9};  // corners do not count
  for (float& mean : pixels.mean[0]) mean *= kUnit;
  // The red values 1, 2, 4, 6, 7 have the mean 4 and the variance (9 + 4 + 0 + 4 + 9) / 4. Green
  // and blue are constant.
  EXPECT_NEAR(errors(estimator, pixels)[4], kCurveSlope * kUnit * std::sqrt(26.0 / 4 / 3), 1e-7);
  // A pixel at the top edge has three neighbours. Here it is 2 with the neighbours 9, 9 and 1.
  EXPECT_NEAR(
      errors(estimator, pixels)[1],
      kCurveSlope * kUnit * std::sqrt((3.25 * 3.25 + 2 * 3.75 * 3.75 + 4.25 * 4.25) / 3 / 3), 1e-7);
  // A pixel at a side of the crop has three neighbours, too. Here they are 9, 9 and 1 for the
  // pixels 4 and 6.
  EXPECT_NEAR(
      errors(estimator, pixels)[3],
      kCurveSlope * kUnit * std::sqrt((1.75 * 1.75 + 2 * 3.25 * 3.25 + 4.75 * 4.75) / 3 / 3), 1e-7);
  EXPECT_NEAR(
      errors(estimator, pixels)[5],
      kCurveSlope * kUnit * std::sqrt((0.25 * 0.25 + 2 * 2.75 * 2.75 + 5.25 * 5.25) / 3 / 3), 1e-7);
  pixels.count[1] = 0.0f;  // leaves 1, 4, 6, 7
  EXPECT_NEAR(errors(estimator, pixels)[4], kCurveSlope * kUnit * std::sqrt(21.0 / 3 / 3), 1e-7);
  pixels.count[4] = 8.0f;  // enough on its own
  EXPECT_EQ(errors(estimator, pixels)[4], 0.0f);
}

TEST(KajiyaEstimator, ByHand) {
  PixelStatistics pixels = constant_pixels(1, 1, kDark, 32.0f);
  pixels.second_count = {8.0f};
  pixels.stream_difference = {{{1e-4f}, {-2e-4f}, {5e-4f}}};
  // The variance of the mean of all samples is difference^2 times 24 * 8 / 32^2.
  const double variance = (1 + 4 + 25) / 3.0 * 1e-8 * 24 * 8 / (32.0 * 32.0);
  EXPECT_NEAR(errors(estimate_kajiya, pixels)[0], kDarkSlope * std::sqrt(variance), 1e-6);
  EXPECT_FLOAT_EQ(half_difference_variance(3.0f, 50.0f, 50.0f), 2.25f);
  pixels.second_count = {32.0f};  // all in one stream
  EXPECT_GT(errors(estimate_kajiya, pixels)[0], kUnfinished);
}

// The noise is about a value above white, and the display shows only the part below 1, here from .9
// on.
TEST(KajiyaEstimator, NoiseThatLeavesWhiteIsSeen) {
  PixelStatistics pixels = constant_pixels(1, 1, 1.1f, 16.0f);
  for (auto& plane : pixels.stream_difference) plane = {0.4f};  // a standard error of .2
  const double shown = 1.0 - (1.055 * std::pow(0.9, 1 / 2.4) - 0.055);
  EXPECT_NEAR(errors(estimate_kajiya, pixels)[0], shown / 2, 1e-4);
}

TEST(ContrastEstimator, ByHand) {
  const Estimator estimator = estimate_contrast;
  PixelStatistics pixels = constant_pixels(6, 3, 0.3f, 8.0f);
  pixels.mean[1][7] = 0.5f;  // green, column 1 of row 1
  const std::vector<float> map = errors(estimator, pixels);
  for (size_t i = 0; i < map.size(); ++i) {
    const float expected = i % 6 <= 2 ? 0.02f * (0.2f / 0.8f) / 0.3f : 0.0f;
    EXPECT_NEAR(map[i], expected, 1e-7f) << i;
  }
  // A darker pixel also has contrast with both neighbours, here .1 to .3.
  pixels.mean[1][7] = 0.1f;
  EXPECT_NEAR(errors(estimator, pixels)[6], 0.02f * 0.5f / 0.3f, 1e-7f);
  EXPECT_NEAR(errors(estimator, pixels)[8], 0.02f * 0.5f / 0.3f, 1e-7f);
  pixels.mean[1][7] = 0.5f;
  // The same contrast has a lower weight in red, and the lowest weight in blue.
  std::swap(pixels.mean[0], pixels.mean[1]);
  EXPECT_NEAR(errors(estimator, pixels)[7], 0.02f * 0.25f / 0.4f, 1e-7f);
  std::swap(pixels.mean[0], pixels.mean[2]);
  EXPECT_NEAR(errors(estimator, pixels)[7], 0.02f * 0.25f / 0.6f, 1e-7f);
}

TEST(ContrastEstimator, UsesDisplayValues) {
  const Estimator estimator = estimate_contrast;
  PixelStatistics pixels = constant_pixels(5, 1, 3.0f, 8.0f);
  pixels.mean[1][2] = 9.0f;  // white next to white
  EXPECT_EQ(errors(estimator, pixels)[2], 0.0f);
  pixels.mean[1][2] = -1.0f;  // as black as 0
  EXPECT_NEAR(errors(estimator, pixels)[1], 0.02f / 0.3f, 1e-7f);
  pixels.count[2] = 0.0f;  // no sample yet
  EXPECT_EQ(errors(estimator, pixels)[1], 0.0f);
  // The limit of the paper is the threshold: .65 and .35 have a contrast of .3.
  pixels = constant_pixels(2, 1, 0.35f, 8.0f);
  pixels.mean[1][1] = 0.65f;
  EXPECT_NEAR(errors(estimator, pixels)[0], kContrastThreshold, 1e-7f);
}

// ---- dammertz ----------------------------------------------------------------------------------

constexpr double kErrorPerDeviation = 2 * 1.7320508075688772 * 0.7978845608028654;

// The error e_p = 3 (d / 2) / sqrt(.75) of a grey pixel of value .25 whose streams differ by +-d.
double grey_error(double d) { return 1.5 * d / std::sqrt(0.75); }

PixelStatistics grey_pixels(int width, int height, float difference) {
  PixelStatistics pixels = constant_pixels(width, height, 0.25f, 16.0f);
  for (auto& plane : pixels.stream_difference) plane.assign(pixels.size(), difference);
  return pixels;
}

TEST(DammertzEstimator, OneBlock) {
  PixelStatistics pixels = grey_pixels(4, 4, 0.01f);
  pixels.stream_difference[1].assign(16, -0.01f);  // the sign does not matter
  const std::vector<float> map = errors(estimate_dammertz, pixels, 0.5f);
  for (const float error : map) {
    EXPECT_NEAR(error, grey_error(0.01) / kErrorPerDeviation, 1e-7);
  }
  // The streams are unequal. I - A is the difference times the share of B.
  pixels.second_count.assign(16, 4.0f);
  EXPECT_NEAR(errors(estimate_dammertz, pixels, 0.5f)[0], grey_error(0.01) / 2 / kErrorPerDeviation,
              1e-7);
}

// The left 8 columns of 32 x 8 pixels hold all the error. Blocks are split at the median of their
// error.
TEST(DammertzEstimator, SplitsWhereTheErrorIs) {
  PixelStatistics pixels = grey_pixels(32, 8, 0.0f);
  for (size_t y = 0; y < 8; ++y) {
    for (size_t x = 0; x < 8; ++x) {
      for (auto& plane : pixels.stream_difference) plane[y * 32 + x] = 0.01f;
    }
  }
  const double e = grey_error(0.01) / kErrorPerDeviation;
  // The whole block has the mean e / 4, so its error is e / 4 sqrt(256 / 16) = e. It is split at
  // column 4. The left part has the error e sqrt(32 / 16). The right part has 28 columns, the mean
  // e / 7 and the error e / 7 sqrt(14).
  const auto at_threshold = [&](double threshold) {
    return errors(estimate_dammertz, pixels, float(threshold));
  };
  std::vector<float> map = at_threshold(1.01 * e);  // finished as a whole
  EXPECT_NEAR(map[0], e, 1e-5 * e);
  EXPECT_NEAR(map[31], e, 1e-5 * e);
  map = at_threshold(0.99 * e / 256);  // too noisy to be split
  EXPECT_NEAR(map[0], e, 1e-5 * e);
  EXPECT_NEAR(map[31], e, 1e-5 * e);
  map = at_threshold(0.9 * e);  // split once; the left part is split again, down to 4 x 4
  EXPECT_NEAR(map[0], e, 1e-5 * e);
  EXPECT_NEAR(map[4], std::sqrt(14.0) / 7 * e, 1e-5 * e);
  EXPECT_NEAR(map[31], std::sqrt(14.0) / 7 * e, 1e-5 * e);
  map = at_threshold(0.0);  // no threshold: splits at columns 4 and 5, then 6, then 7
  EXPECT_NEAR(map[4], e, 1e-5 * e);
  EXPECT_NEAR(map[6], std::sqrt(0.5) * e, 1e-5 * e);
  EXPECT_NEAR(map[7], std::sqrt(0.5) * e, 1e-5 * e);
  EXPECT_EQ(map[8], 0.0f);
}

// The rule of the estimator, in plain loops.
class NaiveBlocks {
 public:
  NaiveBlocks(std::vector<uint64_t> errors, int width, double threshold)
      : errors_(std::move(errors)), map_(errors_.size()), width_(width), threshold_(threshold) {}

  const std::vector<double>& judge(const Rect& block) {
    const auto area = double(block.area());
    const double error =
        double(sum(block)) * 0x1p-24 / area * std::sqrt(area / 16) / kErrorPerDeviation;
    if (error <= threshold_ || error >= 256 * threshold_ || area <= 16) {
      for (int y = block.y0; y < block.y1; ++y) {
        for (int x = block.x0; x < block.x1; ++x) map_[size_t(y * width_ + x)] = error;
      }
      return map_;
    }
    Rect first = block, second = block;
    int Rect::*const end = block.width() >= block.height() ? &Rect::x1 : &Rect::y1;
    int Rect::*const begin = block.width() >= block.height() ? &Rect::x0 : &Rect::y0;
    first.*end = first.*begin + 1;
    while (first.*end < block.*end - 1 && 2 * sum(first) < sum(block)) ++(first.*end);
    second.*begin = first.*end;
    judge(first);
    return judge(second);
  }

 private:
  uint64_t sum(const Rect& block) const {
    uint64_t total = 0;
    for (int y = block.y0; y < block.y1; ++y) {
      for (int x = block.x0; x < block.x1; ++x) total += errors_[size_t(y * width_ + x)];
    }
    return total;
  }

  std::vector<uint64_t> errors_;
  std::vector<double> map_;
  int width_;
  double threshold_;
};

TEST(DammertzEstimator, AgreesWithTheRuleInPlainLoops) {
  constexpr int kWidth = 53, kHeight = 37;
  PixelStatistics pixels = grey_pixels(kWidth, kHeight, 0.0f);
  std::vector<uint64_t> pixel_errors(pixels.size());
  for (size_t i = 0; i < pixels.size(); ++i) {
    TestRandom random(11, i);
    // The noise is high on the left and low on the right.
    const double scale = i % kWidth < 20 ? 0.2 : 0.002;
    const auto difference = float(scale * random.next_double());
    for (auto& plane : pixels.stream_difference) plane[i] = difference;
    // Rounds as the estimator does.
    pixel_errors[i] = uint64_t(0.5f * (3 * difference) / std::sqrt(0.75f) * 0x1p24f);
  }
  for (const float threshold : {1e-5f, 1e-4f, 0.001f, 0.004f, 0.02f, 0.2f}) {
    NaiveBlocks naive(pixel_errors, kWidth, double(threshold));
    const std::vector<double>& expected = naive.judge({0, 0, kWidth, kHeight});
    const std::vector<float> map = errors(estimate_dammertz, pixels, threshold);
    for (size_t i = 0; i < map.size(); ++i) {
      ASSERT_NEAR(map[i], expected[i], 1e-5 * expected[i]) << i << " at " << threshold;
    }
  }
}

// A pixel without an estimate or with NaN does not count for its block.
TEST(DammertzEstimator, BlocksIgnoreUnknownPixels) {
  PixelStatistics pixels = grey_pixels(4, 4, 0.01f);
  pixels.second_count[5] = 16.0f;  // the first stream has none
  pixels.stream_difference[0][6] = kNaN;
  const std::vector<float> map = errors(estimate_dammertz, pixels, 0.5f);
  EXPECT_GT(map[5], kUnfinished);
  EXPECT_NEAR(map[0], grey_error(0.01) / kErrorPerDeviation * 14 / 16, 1e-7);
  EXPECT_EQ(map[6], map[0]);
}

// The error of a pixel is clamped to 256, so that sums cannot overflow. This also holds where the
// negative lobes of a filter leave noise without light.
TEST(DammertzEstimator, HugeErrorsAreCounted) {
  for (const bool dark : {false, true}) {
    PixelStatistics pixels = grey_pixels(4, 4, 0.0f);
    for (size_t c = 0; c < 3; ++c) {
      pixels.stream_difference[c][3] = dark ? 1.0f : 1e30f;
      if (dark) pixels.mean[c][3] = 0.0f;
    }
    EXPECT_NEAR(errors(estimate_dammertz, pixels, 0.5f)[0], 256.0 / 16 / kErrorPerDeviation, 1e-5);
  }
}

}  // namespace
}  // namespace emberline
