// Compares the error metrics with closed forms, hand-computed values and a naive SSIM.
#include "renderer/statistics/error_metrics.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <limits>
#include <random>

#include "renderer/statistics/ssim.h"
#include "support/constant_picture.h"

namespace emberline {
namespace {

using test::constant_picture;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

RgbImage noise(int width, int height, unsigned seed, float low = 0.0f, float high = 1.0f) {
  std::mt19937 random(seed);
  RgbImage image{width, height, {}};
  for (int i = 0; i < 3 * width * height; ++i) {
    image.rgb.push_back(low + (high - low) * float(random() >> 8) * 0x1p-24f);
  }
  return image;
}

TEST(ErrorMetrics, EqualImages) {
  const RgbImage image = noise(37, 23, 1);
  const ErrorMetrics metrics = compare_images(image, image);
  EXPECT_EQ(metrics.mse, 0);
  EXPECT_EQ(metrics.rmse, 0);
  EXPECT_EQ(metrics.rel_mse, 0);
  EXPECT_EQ(metrics.rel_mse_trimmed, 0);
  EXPECT_EQ(metrics.signed_bias, 0);
  EXPECT_EQ(metrics.psnr, double(kInfinity));
  EXPECT_NEAR(metrics.ssim, 1.0, 1e-12);
  EXPECT_EQ(metrics.flip, 0);
  EXPECT_EQ(metrics.max_absolute, 0);
  EXPECT_EQ(metrics.non_finite, 0u);
  EXPECT_EQ(metrics.different_pixels, 0u);
}

TEST(ErrorMetrics, ConstantOffset) {
  // All channels have x = 3/4 and r = 1/2, which are exact in binary.
  const ErrorMetrics metrics = compare_images(constant_picture(16, 12, 0.75f, 0.75f, 0.75f),
                                              constant_picture(16, 12, 0.5f, 0.5f, 0.5f));
  EXPECT_EQ(metrics.mse, 0.0625);
  EXPECT_EQ(metrics.rmse, 0.25);
  EXPECT_EQ(metrics.max_absolute, 0.25);
  EXPECT_EQ(metrics.signed_bias, 0.5);
  EXPECT_DOUBLE_EQ(metrics.rel_mse_epsilon, 0.01 * 0.25);
  EXPECT_NEAR(metrics.rel_mse, 0.0625 / (0.25 + 0.0025), 1e-12);
  EXPECT_EQ(metrics.different_pixels, 16u * 12u);
  // As displayed, 0.75 is 0.880825 and 0.5 is 0.735357 (IEC 61966-2-1).
  const double shown = 1.055 * (std::pow(0.75, 1 / 2.4) - std::pow(0.5, 1 / 2.4));
  EXPECT_NEAR(metrics.psnr, -20 * std::log10(shown), 1e-4);
}

TEST(ErrorMetrics, ChannelsAndSign) {
  // The differences from r = 1, 4, 5 are +1, -2, +3. Their sum is 2, and the sum of r is 10. Their
  // mean square is (1 + 4 + 9) / 3.
  const ErrorMetrics metrics =
      compare_images(constant_picture(3, 3, 2, 2, 8), constant_picture(3, 3, 1, 4, 5));
  EXPECT_DOUBLE_EQ(metrics.mse, 14.0 / 3.0);
  EXPECT_DOUBLE_EQ(metrics.signed_bias, 0.2);
  EXPECT_EQ(metrics.max_absolute, 3);
  const double epsilon = 0.01 * 100.0 / 9.0;
  EXPECT_DOUBLE_EQ(metrics.rel_mse_epsilon, epsilon);
  EXPECT_DOUBLE_EQ(metrics.rel_mse,
                   (1 / (1 + epsilon) + 4 / (16 + epsilon) + 9 / (25 + epsilon)) / 3);
}

TEST(ErrorMetrics, BlackReference) {
  const RgbImage black = constant_picture(12, 12, 0, 0, 0);
  const ErrorMetrics metrics = compare_images(constant_picture(12, 12, 0.1f, 0.1f, 0.1f), black);
  EXPECT_EQ(metrics.signed_bias, double(kInfinity));
  EXPECT_EQ(metrics.rel_mse_epsilon, 0.01);
  EXPECT_NEAR(metrics.rel_mse, 1.0, 1e-6);
  EXPECT_EQ(compare_images(black, black).signed_bias, 0);
}

TEST(ErrorMetrics, TrimmingLeavesOutTheWorstThousandth) {
  // The worst two of 2000 pixels are trimmed: a firefly, and a pixel that is half as bad. All
  // others are off by 1/8.
  RgbImage image = constant_picture(50, 40, 1.125f, 1.125f, 1.125f);
  const RgbImage reference = constant_picture(50, 40, 1, 1, 1);
  for (size_t c = 0; c < 3; ++c) {
    image.rgb[3 * 777 + c] = 1001.0f;
    image.rgb[3 * 1500 + c] = 501.0f;
  }
  const ErrorMetrics metrics = compare_images(image, reference);
  EXPECT_NEAR(metrics.rel_mse_trimmed, 0.125 * 0.125 / 1.01, 1e-12);
  EXPECT_NEAR(metrics.rel_mse, (1e6 + 25e4 + 1998 * 0.125 * 0.125) / 2000 / 1.01, 1e-6);
  // Below a thousand pixels nothing is trimmed.
  const ErrorMetrics few = compare_images(noise(20, 20, 1), noise(20, 20, 2));
  EXPECT_EQ(few.rel_mse_trimmed, few.rel_mse);
}

TEST(ErrorMetrics, NonFinitePixelsAreCountedAndLeftOut) {
  RgbImage image = noise(40, 30, 3), reference = noise(40, 30, 4);
  const auto spoil = [](RgbImage& target, size_t pixel, float value) {
    target.rgb[3 * pixel + pixel % 3] = value;
  };
  // If these pixels are black in both pictures, the metrics are those of the other pixels.
  RgbImage clean = image, clean_reference = reference;
  for (const size_t pixel : {size_t(0), size_t(615), size_t(1199)}) {
    for (size_t c = 0; c < 3; ++c)
      clean.rgb[3 * pixel + c] = clean_reference.rgb[3 * pixel + c] = 0;
  }
  spoil(image, 0, kNaN);
  spoil(image, 615, kInfinity);
  spoil(reference, 1199, -kInfinity);
  spoil(reference, 0, kNaN);  // counted once

  const ErrorMetrics metrics = compare_images(image, reference);
  const ErrorMetrics expected = compare_images(clean, clean_reference);
  EXPECT_EQ(metrics.non_finite, 3u);
  EXPECT_EQ(expected.non_finite, 0u);
  const double weight = 1200.0 / 1197.0;
  EXPECT_NEAR(metrics.mse, expected.mse * weight, 1e-12);
  EXPECT_NEAR(metrics.signed_bias, expected.signed_bias, 1e-12);
  // FLIP is not 0 at an equal pixel whose surroundings differ, but a non-finite pixel is left out
  // of it.
  EXPECT_NEAR(metrics.flip, expected.flip * weight, 3.0 / 1197.0);
  EXPECT_TRUE(std::isfinite(metrics.ssim));
  EXPECT_TRUE(std::isfinite(metrics.psnr));
  EXPECT_TRUE(std::isfinite(metrics.rel_mse));
}

TEST(ErrorMetrics, NothingFinite) {
  const RgbImage bad = constant_picture(4, 4, kNaN, 0, 0);
  const ErrorMetrics metrics = compare_images(bad, bad);
  EXPECT_EQ(metrics.non_finite, 16u);
  EXPECT_EQ(metrics.different_pixels, 0u);  // bitwise equal
  EXPECT_TRUE(std::isnan(metrics.mse));
  EXPECT_TRUE(std::isnan(metrics.ssim));
  EXPECT_TRUE(std::isnan(metrics.flip));
}

TEST(ErrorMetrics, HugeAndTinyValues) {
  const float largest = std::numeric_limits<float>::max();
  const ErrorMetrics metrics = compare_images(constant_picture(12, 12, largest, 1e-40f, 0),
                                              constant_picture(12, 12, -largest, 0, 0));
  EXPECT_TRUE(std::isfinite(metrics.mse));
  EXPECT_TRUE(std::isfinite(metrics.rel_mse));
  EXPECT_DOUBLE_EQ(metrics.max_absolute, 2 * double(largest));
}

TEST(ErrorMetrics, ExposureChangesOnlyDisplayMetrics) {
  const RgbImage image = noise(24, 24, 5, 0, 0.2f), reference = noise(24, 24, 6, 0, 0.2f);
  RgbImage image4 = image, reference4 = reference;
  for (float& value : image4.rgb) value *= 4;
  for (float& value : reference4.rgb) value *= 4;
  const ErrorMetrics exposed = compare_images(image, reference, {2.0f});
  const ErrorMetrics scaled = compare_images(image4, reference4);
  EXPECT_EQ(exposed.psnr, scaled.psnr);
  EXPECT_EQ(exposed.ssim, scaled.ssim);
  EXPECT_EQ(exposed.flip, scaled.flip);
  EXPECT_EQ(exposed.mse * 16, scaled.mse);
  EXPECT_NE(exposed.flip, compare_images(image, reference).flip);
}

TEST(ErrorMetrics, GrowWithNoise) {
  const RgbImage reference = noise(64, 48, 7, 0.2f, 0.6f);
  const RgbImage grain = noise(64, 48, 8, -1.0f, 1.0f);
  ErrorMetrics before = compare_images(reference, reference);
  for (const float strength : {0.01f, 0.02f, 0.05f, 0.1f, 0.2f}) {
    RgbImage image = reference;
    for (size_t i = 0; i < image.rgb.size(); ++i) image.rgb[i] += strength * grain.rgb[i];
    const ErrorMetrics metrics = compare_images(image, reference);
    EXPECT_GT(metrics.mse, before.mse);
    EXPECT_GT(metrics.rel_mse, before.rel_mse);
    EXPECT_GT(metrics.rel_mse_trimmed, before.rel_mse_trimmed);
    EXPECT_LT(metrics.psnr, before.psnr);
    EXPECT_LT(metrics.ssim, before.ssim);
    EXPECT_GT(metrics.flip, before.flip);
    before = metrics;
  }
}

TEST(ErrorMetrics, SameBitsForAnyNumberOfThreads) {
  const RgbImage image = noise(101, 83, 9), reference = noise(101, 83, 10);
  const ErrorMetrics many = compare_images(image, reference);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const ErrorMetrics single = compare_images(image, reference);
  EXPECT_EQ(many.mse, single.mse);
  EXPECT_EQ(many.rel_mse, single.rel_mse);
  EXPECT_EQ(many.rel_mse_trimmed, single.rel_mse_trimmed);
  EXPECT_EQ(many.signed_bias, single.signed_bias);
  EXPECT_EQ(many.psnr, single.psnr);
  EXPECT_EQ(many.ssim, single.ssim);
  EXPECT_EQ(many.flip, single.flip);
}

// ---- SSIM --------------------------------------------------------------------------------------

double ssim_formula(double mean_a, double mean_b, double var_a, double var_b, double covariance) {
  const double c1 = 0.0001, c2 = 0.0009;
  return (2 * mean_a * mean_b + c1) * (2 * covariance + c2) /
         ((mean_a * mean_a + mean_b * mean_b + c1) * (var_a + var_b + c2));
}

TEST(Ssim, ConstantPlanes) {
  const std::vector<float> a(20 * 15, 0.25f), b(20 * 15, 0.75f);
  const std::vector<uint8_t> none(20 * 15, 0);
  EXPECT_NEAR(mean_ssim(a, b, none, 20, 15), ssim_formula(0.25, 0.75, 0, 0, 0), 1e-12);
}

TEST(Ssim, OnePixelAndTwo) {
  EXPECT_NEAR(mean_ssim({0.2f}, {0.6f}, {0}, 1, 1),
              ssim_formula(double(0.2f), double(0.6f), 0, 0, 0), 1e-12);
  // Two pixels have weights of 1/2 each. For a = 0, 1 the mean is 1/2 and the variance 1/4. For b =
  // 1/2, 1 the mean is 3/4 and the variance 1/16. The covariance is 1/2 - 3/8 = 1/8.
  EXPECT_NEAR(mean_ssim({0.0f, 1.0f}, {0.5f, 1.0f}, {0, 0}, 2, 1),
              ssim_formula(0.5, 0.75, 0.25, 0.0625, 0.125), 1e-12);
}

TEST(Ssim, ThreeByThreeByHand) {
  // The weights are in the ratio exp(-1 / 4.5) : 1 : exp(-1 / 4.5), so they are 0.307801, 0.384398
  // and 0.307801. One pixel is bright in the middle of a, and one in a corner of b. The means are
  // w1^2 and w0^2, E[a^2] and E[b^2] are the same, and E[ab] is 0.
  const double side = std::exp(-1.0 / 4.5);
  const double w1 = 1 / (1 + 2 * side), w0 = side * w1;
  const double p = w1 * w1, q = w0 * w0;
  const std::vector<float> a = {0, 0, 0, 0, 1, 0, 0, 0, 0}, b = {1, 0, 0, 0, 0, 0, 0, 0, 0};
  EXPECT_NEAR(mean_ssim(a, b, std::vector<uint8_t>(9, 0), 3, 3),
              ssim_formula(p, q, p - p * p, q - q * q, -p * q), 1e-12);
}

// Computes every window separately, with the two-dimensional Gaussian.
double naive_ssim(const std::vector<float>& a, const std::vector<float>& b,
                  const std::vector<uint8_t>& masked, int width, int height) {
  double weights[11][11], total = 0;
  for (int j = 0; j < 11; ++j) {
    for (int i = 0; i < 11; ++i) {
      weights[j][i] = std::exp(-((i - 5) * (i - 5) + (j - 5) * (j - 5)) / (2 * 1.5 * 1.5));
      total += weights[j][i];
    }
  }
  double sum = 0;
  int windows = 0;
  for (int y = 0; y + 11 <= height; ++y) {
    for (int x = 0; x + 11 <= width; ++x) {
      double mean_a = 0, mean_b = 0, var_a = 0, var_b = 0, covariance = 0;
      bool bad = false;
      const auto each = [&](const auto& fn) {
        for (int j = 0; j < 11; ++j) {
          for (int i = 0; i < 11; ++i) {
            const size_t index = size_t((y + j) * width + x + i);
            fn(weights[j][i] / total, double(a[index]), double(b[index]), index);
          }
        }
      };
      each([&](double w, double p, double q, size_t index) {
        mean_a += w * p;
        mean_b += w * q;
        bad |= masked[index] != 0;
      });
      each([&](double w, double p, double q, size_t) {
        var_a += w * (p - mean_a) * (p - mean_a);
        var_b += w * (q - mean_b) * (q - mean_b);
        covariance += w * (p - mean_a) * (q - mean_b);
      });
      if (bad) continue;
      sum += ssim_formula(mean_a, mean_b, var_a, var_b, covariance);
      ++windows;
    }
  }
  return sum / windows;
}

TEST(Ssim, AgreesWithTheNaiveForm) {
  const int width = 41, height = 29;
  std::mt19937 random(11);
  std::vector<float> a, b;
  std::vector<uint8_t> masked(size_t(width * height), 0);
  for (int i = 0; i < width * height; ++i) {
    a.push_back(float(random() >> 8) * 0x1p-24f);
    b.push_back(0.7f * a.back() + 0.3f * float(random() >> 8) * 0x1p-24f);
  }
  EXPECT_NEAR(mean_ssim(a, b, masked, width, height), naive_ssim(a, b, masked, width, height),
              1e-10);
  masked[3] = masked[500] = 1;
  EXPECT_NEAR(mean_ssim(a, b, masked, width, height), naive_ssim(a, b, masked, width, height),
              1e-10);
  EXPECT_NEAR(mean_ssim(a, b, masked, width, height), mean_ssim(b, a, masked, width, height),
              1e-12);
  masked.assign(masked.size(), 1);
  EXPECT_TRUE(std::isnan(mean_ssim(a, b, masked, width, height)));
}

}  // namespace
}  // namespace emberline
