// Tests the calibration of the historical estimators on pixels with a known distribution, and the
// bias of their stopping rules. Pixel i of a test uses TestRandom(seed, i), so that any pixel can
// be replayed alone. Shares and means are checked to 5 standard deviations plus the stated
// allowances. With other seeds, each check would give one false alarm in 2e6 runs.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "renderer/drivers/adaptive/chi_square_estimator.h"
#include "renderer/drivers/adaptive/dammertz_estimator.h"
#include "renderer/drivers/adaptive/kajiya_estimator.h"
#include "renderer/drivers/adaptive/painter_sloan_estimator.h"
#include "renderer/drivers/adaptive/quantiles.h"
#include "support/long_tests.h"
#include "unit/synthetic_pixels.h"

namespace emberline {
namespace {

using test::drawn_pixels;
using test::SamplePixel;
using test::TestRandom;

// Five standard deviations of the share of hits in `count` draws that hit with probability `p`.
double share_tolerance(double p, double count) { return 5 * std::sqrt(p * (1 - p) / count); }

// ---- quantiles ---------------------------------------------------------------------------------

TEST(Quantiles, ChiSquareAgreesWithTables) {
  const std::pair<double, double> kTable[] = {{7, 2.16735},   {10, 3.94030},  {15, 7.26094},
                                              {20, 10.85081}, {31, 19.28057}, {100, 77.92947}};
  for (const auto& [degrees, value] : kTable) {
    const double known = degrees < 31 ? 6e-3 : 2e-4;
    EXPECT_NEAR(chi_square_quantile_05(degrees) / value, 1.0, known) << degrees;
    EXPECT_LT(chi_square_quantile_05(degrees), value * (1 + 1e-6)) << degrees;  // the safe side
  }
}

// Computes the probability below the quantile with the incomplete gamma function.
TEST(Quantiles, ChiSquareLeavesFivePercent) {
  for (const int degrees : {7, 15, 31, 63, 127, 1023, 65535}) {
    const double below = 1 - test::chi_square_p_value(chi_square_quantile_05(degrees), degrees);
    EXPECT_NEAR(below, 0.05, degrees < 31 ? 8e-4 : 1e-4) << degrees;
  }
}

TEST(Quantiles, StudentAgreesWithTables) {
  const std::pair<double, double> kTable[] = {
      {1, 12.7062},  {2, 4.30265},  {3, 3.18245},  {4, 2.77645},  {5, 2.57058},   {7, 2.36462},
      {10, 2.22814}, {15, 2.13145}, {30, 2.04227}, {60, 2.00030}, {120, 1.97993}, {1e6, 1.95997}};
  for (const auto& [degrees, value] : kTable) {
    EXPECT_NEAR(student_t_quantile_975(degrees) / value, 1.0, degrees < 7 ? 1.3e-3 : 3e-5)
        << degrees;
  }
}

// ---- calibration -------------------------------------------------------------------------------

// The upper 95 % confidence bound of the variance of the mean of `count` samples. `variance` is the
// variance of one sample.
float chi_square_bound(float variance, float count) {
  const double degrees = double(count) - 1.0;
  return variance / count * float(degrees / chi_square_quantile_05(degrees));
}

// Half the width of the 95 % confidence interval of the mean of `count` samples.
float confidence_half_width(float variance, float count) {
  return float(student_t_quantile_975(double(count) - 1.0)) * std::sqrt(variance / count);
}

constexpr int kSide = 200;  // of a window, which has 40,000 pixels
constexpr double kPixels = kSide * kSide;

// The slope of the sRGB curve in its nonlinear part.
double display_slope(double x) { return 1.055 / 2.4 * std::pow(x, 1 / 2.4 - 1); }

std::vector<float> errors_of(decltype(EstimatorEntry::estimate) estimate,
                             const PixelStatistics& pixels, float threshold = 0.01f) {
  ErrorMap map;
  estimate(pixels, {.threshold = threshold}, &map);
  return map.error;
}

// The samples are normal around .5. There the display curve is straight over the noise of a mean.
constexpr double kMean = 0.5, kDeviation = 0.05;
PixelStatistics normal_pixels(uint32_t count, uint64_t seed) {
  return drawn_pixels(kSide, kSide, count, seed, [](TestRandom& random) {
    return kMean + kDeviation * test::draw_normal(random);
  });
}
double true_error(uint32_t count) {
  return display_slope(kMean) * kDeviation / std::sqrt(double(count));
}

// The share of the window's pixels for which holds(i) is true.
double share(const std::function<bool(size_t)>& holds) {
  double count = 0;
  for (size_t i = 0; i < size_t(kPixels); ++i) count += holds(i) ? 1 : 0;
  return count / kPixels;
}

// The true variance is below the bound in 95 % of the pixels. The tolerance includes .1 % for the
// error of the quantile.
TEST(ChiSquareCalibration, TheBoundHoldsIn95Percent) {
  for (const uint32_t n : {8u, 16u, 64u}) {
    const PixelStatistics pixels = normal_pixels(n, 100 + n);
    const auto bound = [&](size_t i) { return chi_square_bound(pixels.variance[0][i], float(n)); };
    const double held = share([&](size_t i) { return kDeviation * kDeviation / n < bound(i); });
    EXPECT_NEAR(held, 0.95, share_tolerance(0.95, kPixels) + 1e-3) << n << ", seed " << 100 + n;
    // Checks the same in display units. The estimator uses the slope at the pixel's mean instead of
    // the true mean, which may change the share by .2 %.
    const std::vector<float> errors = errors_of(estimate_chi_square, pixels);
    const double shown = share([&](size_t i) { return true_error(n) < double(errors[i]); });
    EXPECT_NEAR(shown, 0.95, share_tolerance(0.95, kPixels) + 3e-3) << n << ", seed " << 100 + n;
  }
}

// The interval contains the true mean in 95 % of the pixels.
TEST(PainterSloanCalibration, TheIntervalHoldsIn95Percent) {
  for (const uint32_t n : {8u, 16u, 64u}) {
    const PixelStatistics pixels = normal_pixels(n, 200 + n);
    const auto width = [&](size_t i) {
      return confidence_half_width(pixels.variance[0][i], float(n));
    };
    const double held = share(
        [&](size_t i) { return std::abs(double(pixels.mean[0][i]) - kMean) <= double(width(i)); });
    EXPECT_NEAR(held, 0.95, share_tolerance(0.95, kPixels)) << n << ", seed " << 200 + n;
    const std::vector<float> errors = errors_of(estimate_painter_sloan, pixels);
    const double shown = share([&](size_t i) {
      return std::abs(display_value(pixels.mean[0][i]) - display_value(float(kMean))) <= errors[i];
    });
    EXPECT_NEAR(shown, 0.95, share_tolerance(0.95, kPixels) + 2e-3) << n << ", seed " << 200 + n;
  }
}

// This is a known flaw with light that one sample in 50 hits. In 85 % (.98^8) of the pixels all
// eight samples are black, and the interval has zero width. Only the other intervals can contain
// the true mean.
TEST(PainterSloanCalibration, RareLightHasNoInterval) {
  constexpr uint64_t kSeed = 7;
  const auto rare = [](TestRandom& random) { return random.next_double() < 0.02 ? 1.0 : 0.0; };
  const std::vector<float> interval =
      errors_of(estimate_painter_sloan, drawn_pixels(kSide, kSide, 8, kSeed, rare));
  const double black = std::pow(0.98, 8);
  EXPECT_NEAR(share([&](size_t i) { return interval[i] == 0.0f; }), black,
              share_tolerance(black, kPixels))
      << "seed " << kSeed;
}

// The estimate has one degree of freedom. It is right on average. With a probability of erf(.5 /
// sqrt 2) = 38 % it is below half the true error, and with 8 % it is below a tenth.
TEST(KajiyaCalibration, OneDegreeOfFreedom) {
  for (const uint32_t n : {16u, 24u, 64u}) {  // 24: two blocks of one stream, one of the other
    const PixelStatistics pixels = normal_pixels(n, 300 + n);
    double sum = 0;
    for (size_t i = 0; i < pixels.size(); ++i) {
      const float b = pixels.second_count[i];
      sum += half_difference_variance(pixels.stream_difference[0][i], float(n) - b, b);
    }
    // The variance of chi-square with one degree of freedom is 2.
    EXPECT_NEAR(sum / kPixels / (kDeviation * kDeviation / n), 1.0, 5 * std::sqrt(2.0 / kPixels))
        << n << ", seed " << 300 + n;
    const std::vector<float> errors = errors_of(estimate_kajiya, pixels);
    for (const double part : {0.5, 0.1}) {
      const double expected = std::erf(part / std::sqrt(2.0));
      const double below = share([&](size_t i) { return errors[i] < part * true_error(n); });
      EXPECT_NEAR(below, expected, share_tolerance(expected, kPixels) + 3e-3)
          << n << ", seed " << 300 + n;
    }
  }
}

// Where the display curve is like the square root, the estimate for a block of 16 pixels is its
// standard error as displayed. The error is far above 256 times the threshold, so no block is split
// and all pixels are pooled. The pooled error is known to 5 sqrt(pi / 2 - 1) / 200 = 2 %. The
// slopes of the display curve and of the square root differ by .6 % at .2.
TEST(DammertzCalibration, TheThresholdIsAStandardErrorOfTheDisplay) {
  constexpr uint64_t kSeed = 400;
  constexpr double kGrey = 0.2, kNoise = 0.02;
  constexpr uint32_t kCount = 16;
  const PixelStatistics pixels = drawn_pixels(kSide, kSide, kCount, kSeed, [&](TestRandom& random) {
    return kGrey + kNoise * test::draw_normal(random);
  });
  const double expected = display_slope(kGrey) * kNoise / std::sqrt(double(kCount)) *
                          std::sqrt(kPixels / kDammertzLeafPixels);
  const std::vector<float> whole = errors_of(estimate_dammertz, pixels, 1e-6f);
  EXPECT_EQ(whole.front(), whole.back());
  EXPECT_NEAR(whole[0] / expected, 1.0, 0.026) << "seed " << kSeed;
}

// ---- bias of stopping on one's own estimate ----------------------------------------------------

struct Light {
  const char* name;
  double mean;
  double (*draw)(TestRandom&);
};
constexpr Light kLights[] = {
    {"one in 10", 0.1, [](TestRandom& r) { return r.next_double() < 0.1 ? 1.0 : 0.0; }},
    {"one in 50", 0.02, [](TestRandom& r) { return r.next_double() < 0.02 ? 1.0 : 0.0; }},
    {"fireflies", 0.3, [](TestRandom& r) { return r.next_double() < 0.005 ? 20.2 : 0.2; }},
    {"exponential", 0.5, [](TestRandom& r) { return -0.5 * std::log1p(-r.next_double()); }},
};

// Takes `batch` samples at a time until the rule's estimate of the variance of the mean is below
// .02^2. The rules are those of the estimators without the display curve, so that radiance is
// linear.
using VarianceRule = double (*)(const SamplePixel&);
constexpr double kTarget = 0.02;

SamplePixel sample_until(VarianceRule rule, uint32_t batch, const Light& light, TestRandom random) {
  constexpr uint32_t kMost = 20000;  // 4 times the samples that the hardest light needs
  SamplePixel pixel;
  do {
    for (uint32_t k = 0; k < batch; ++k) pixel.add(light.draw(random));
  } while (rule(pixel) >= kTarget * kTarget && pixel.count() < kMost);
  return pixel;
}

struct Loss {
  double bias;       // of the mean, relative and signed
  double tolerance;  // five standard errors of the bias
};

Loss measure_loss(VarianceRule rule, uint32_t batch, const Light& light, uint64_t seed) {
  const uint64_t runs = test::long_or_short(40000u, 10000u);
  double sum = 0, squares = 0;
  for (uint64_t i = 0; i < runs; ++i) {
    const double x = sample_until(rule, batch, light, TestRandom(seed, i)).mean() / light.mean - 1;
    sum += x;
    squares += x * x;
  }
  const double mean = sum / double(runs);
  return {mean, 5 * std::sqrt((squares / double(runs) - mean * mean) / double(runs))};
}

// Checks the losses against `expected`, which an independent program with another generator has
// measured to .6 %.
void expect_losses(VarianceRule rule, uint32_t batch, uint64_t seed, const double (&expected)[4]) {
  constexpr double kKnown = 0.006;
  for (size_t i = 0; i < 4; ++i) {
    const Loss loss = measure_loss(rule, batch, kLights[i], seed + i);
    EXPECT_NEAR(loss.bias, expected[i], loss.tolerance + kKnown)
        << kLights[i].name << ", seed " << seed + i;
  }
}

TEST(SelfStopping, ChiSquareLosesRareLight) {
  const VarianceRule rule = [](const SamplePixel& p) {
    return double(chi_square_bound(float(p.variance()), float(p.count())));
  };
  expect_losses(rule, kChiSquareBatch, 500, {-0.43, -0.80, -0.32, -0.002});
  // Most of the light is lost at the first test: in .9^8 of the pixels, all eight samples are
  // black.
  EXPECT_LT(measure_loss(rule, 8, kLights[0], 500).bias, -std::pow(0.9, 8) + 0.02);
}

// The rule divides the half width by 1.96, which is the half width in standard errors for many
// samples, and squares the result.
TEST(SelfStopping, PainterSloanLosesAsMuch) {
  const VarianceRule rule = [](const SamplePixel& p) {
    const double width = confidence_half_width(float(p.variance()), float(p.count())) / kNormal975;
    return width * width;
  };
  expect_losses(rule, kPainterSloanBatch, 510, {-0.44, -0.78, -0.32, -0.003});
}

TEST(SelfStopping, KajiyaLosesLessOfTheCommonAndMoreOfTheSmooth) {
  const VarianceRule rule = [](const SamplePixel& p) {
    const auto b = float(p.second_count());
    return double(half_difference_variance(float(p.stream_difference()), float(p.count()) - b, b));
  };
  expect_losses(rule, kKajiyaBatch, 520, {-0.094, -0.46, -0.257, -0.012});
}

}  // namespace
}  // namespace emberline
