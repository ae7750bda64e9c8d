// Tests errors against a noisy reference, and the Neyman limit, on pictures with a known truth.
#include "renderer/statistics/reference_error.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "renderer/core/hash.h"
#include "renderer/statistics/neyman_limit.h"

namespace emberline {
namespace {

constexpr int kWidth = 64, kHeight = 48;

// Uniform noise in [-1, 1), with variance 1/3, for value `i` of the picture with this seed.
double noise(uint32_t seed, size_t i) {
  return 2 * double(to_unit_float(hash_combine(hash32(seed), uint32_t(i)))) - 1;
}

// The true picture is a ramp from dark to above white.
double truth(size_t i) { return 0.05 + 1.5 * double(i) / (3 * kWidth * kHeight); }

RgbImage picture(uint32_t seed, double amplitude, double offset = 0) {
  RgbImage image{kWidth, kHeight, std::vector<float>(size_t(3 * kWidth * kHeight))};
  for (size_t i = 0; i < image.rgb.size(); ++i) {
    image.rgb[i] = float(truth(i) + offset + amplitude * noise(seed, i));
  }
  return image;
}

// Let x have the variance X, and each half, a and b, the variance R. The mean over N values of
// products (x - a)(x - b) has the variance (X (X (k - 1) + 2 R) + R^2) / N, where k = 9/5 is the
// kurtosis of the uniform distribution. There are 40 pictures of 9216 values. The tolerance is 5
// standard deviations, with a false-alarm rate of 6e-7.
TEST(ReferenceError, ProductsOfTwoHalvesAreFreeOfTheReferencesNoise) {
  constexpr int kPictures = 40;
  const double x = 0.1 * 0.1 / 3;
  for (const double amplitude : {0.05, 0.3}) {
    const double r = amplitude * amplitude / 3;
    double products = 0, squares = 0, relative = 0;
    for (uint32_t k = 0; k < kPictures; ++k) {
      const RgbImage a = picture(3 * k + 1, amplitude), b = picture(3 * k + 2, amplitude);
      const ReferencePicture halves(a, b);
      const RgbImage p = picture(3 * k + 3, 0.1);
      products += halves.measure(p).mse / kPictures;
      squares += ReferencePicture(halves.mean()).measure(p).mse / kPictures;
      relative += halves.measure(p).rel_mse / kPictures;
    }
    const double n = kPictures * 3.0 * kWidth * kHeight;
    const double deviation = std::sqrt((x * (0.8 * x + 2 * r) + r * r) / n);
    EXPECT_NEAR(products, x, 5 * deviation) << "pictures 1 to " << 3 * kPictures << " of noise()";
    // Squares of the difference from the mean contain half of r, so the test is sensitive.
    EXPECT_NEAR(squares, x + r / 2, 5 * deviation);
    EXPECT_GT(r / 2, 10 * deviation);
    EXPECT_GT(relative, 0);
  }
}

// The truth has no error, however noisy the halves are. Products of display values also cancel,
// except for the curvature of the display curve over the noise of the halves.
TEST(ReferenceError, TheTruthHasHardlyAnyErrorOnTheDisplay) {
  const ReferencePicture halves(picture(1, 0.02), picture(2, 0.02));
  StudyReference reference;
  halves.set_noise(&reference);
  const StudyError error = halves.measure(picture(3, 0));
  // The mean of 9216 products has a standard deviation of 2 / sqrt(9216) = .02 times the noise.
  EXPECT_NEAR(error.display_mse, 0, 0.15 * reference.noise_display_mse);
  EXPECT_NEAR(error.mse, 0, 0.15 * reference.noise_mse);
  EXPECT_NEAR(error.rel_mse, 0, 0.5 * reference.noise_rel_mse);
}

TEST(ReferenceError, NoiseIsThatOfTheMean) {
  const ReferencePicture halves(picture(1, 0.3), picture(2, 0.3));
  StudyReference reference;
  halves.set_noise(&reference);
  // The variance of a half is 0.03, and that of the mean is 0.015. The estimate from 9216 values
  // has a relative deviation of about sqrt((k - 1) / n) < 2 %.
  EXPECT_NEAR(reference.noise_mse, 0.015, 5 * 0.02 * 0.015);
  EXPECT_GT(reference.noise_rel_mse, 0);
  EXPECT_GT(reference.noise_display_mse, 0);
  EXPECT_EQ(reference.rel_mse_epsilon, halves.epsilon());
  const double sum = 3 * kWidth * kHeight * 0.8;
  EXPECT_NEAR(reference.noise_bias, std::sqrt(3 * 0.015 * 3 * kWidth * kHeight) / sum, 2e-4);
  ReferencePicture(picture(1, 0.3)).set_noise(&reference);
  EXPECT_EQ(reference.noise_mse, 0);
}

// With a single reference picture the figures equal those of `emberline compare`.
TEST(ReferenceError, AgainstOnePictureItIsTheOrdinaryError) {
  const RgbImage x = picture(1, 0.1), r = picture(2, 0.02);
  const ErrorMetrics plain = compare_images(x, r);
  const StudyError error = ReferencePicture(r).measure(x);
  EXPECT_NEAR(error.mse, plain.mse, 1e-12);
  EXPECT_NEAR(error.rel_mse, plain.rel_mse, 1e-12 * plain.rel_mse + 1e-15);
  EXPECT_NEAR(error.rel_mse_trimmed, plain.rel_mse_trimmed, 1e-9 * plain.rel_mse);
  EXPECT_NEAR(error.signed_bias, plain.signed_bias, 1e-9);
  EXPECT_NEAR(error.flip, plain.flip, 1e-9);
  EXPECT_NEAR(error.display_mse, std::pow(10, -plain.psnr / 10), 1e-9);
  EXPECT_EQ(ReferencePicture(r).flip(r), std::vector<float>(size_t(kWidth * kHeight), 0.0f));
}

TEST(ReferenceError, BiasPercentilesAndWorstPixels) {
  const RgbImage r = picture(1, 0);
  RgbImage x = picture(1, 0, 0.01);
  StudyError error = ReferencePicture(r).measure(x);
  EXPECT_NEAR(error.signed_bias, 0.01 / 0.8, 1e-5);
  EXPECT_NEAR(error.p95_absolute, 0.01, 1e-6);
  // First 4 % and then 6 % of the pixels are far off. Only the 6 % affect the percentile.
  for (const double share : {0.04, 0.06}) {
    x = r;
    for (size_t i = 0; i < size_t(3 * share * kWidth * kHeight); ++i) x.rgb[i] += 1;
    error = ReferencePicture(r).measure(x);
    EXPECT_NEAR(error.p95_absolute, share < 0.05 ? 0 : 1, 1e-6);
    EXPECT_NEAR(error.mse, share, 1e-3);
  }
  // Three pixels of 3072 are a thousandth, rounded down.
  x = r;
  for (const size_t pixel : {100u, 200u, 300u}) x.rgb[3 * pixel] += 50;
  error = ReferencePicture(r).measure(x);
  EXPECT_GT(error.rel_mse, 1);
  EXPECT_EQ(error.rel_mse_trimmed, 0);
}

// If all light is scaled by a factor, errors scale by the factor or its square, and relative errors
// stay the same.
TEST(ReferenceError, AFactorOfAllLightIsOneOfTheErrors) {
  const auto scaled = [](RgbImage image, int exponent) {
    for (float& value : image.rgb) value = std::ldexp(value, exponent);
    return image;
  };
  const auto measured = [&](int exponent) {
    return ReferencePicture(scaled(picture(1, 0.1), exponent), scaled(picture(2, 0.1), exponent))
        .measure(scaled(picture(3, 0.1), exponent));
  };
  const StudyError plain = measured(0);
  for (int exponent = -20; exponent <= 20; ++exponent) {
    SCOPED_TRACE(exponent);
    const StudyError error = measured(exponent);
    EXPECT_NEAR(std::ldexp(error.mse, -2 * exponent) / plain.mse, 1, 1e-9);
    EXPECT_NEAR(error.rel_mse / plain.rel_mse, 1, 1e-9);
    EXPECT_NEAR(error.rel_mse_trimmed / plain.rel_mse_trimmed, 1, 1e-9);
    EXPECT_NEAR(error.signed_bias / plain.signed_bias, 1, 1e-9);
    EXPECT_NEAR(std::ldexp(error.p95_absolute, -exponent) / plain.p95_absolute, 1, 1e-9);
    for (const double shown : {error.display_mse, error.p95_display, error.flip}) {
      EXPECT_TRUE(std::abs(shown) <= 1) << shown;
    }
    const std::vector<float> variance(size_t(3 * kWidth * kHeight),
                                      std::ldexp(0.01f, 2 * exponent));
    const std::vector<float> seconds(size_t(kWidth * kHeight), 1.0f);
    const NeymanLimits limits = neyman_limits(variance, seconds, scaled(picture(3, 0.1), exponent),
                                              std::ldexp(0.01, 2 * exponent));
    EXPECT_NEAR(limits.mse, 1, 1e-6);
    EXPECT_TRUE(std::isfinite(limits.rel_mse) && std::isfinite(limits.display));
  }
}

TEST(ReferenceError, PixelsThatAreNotFiniteAreLeftOut) {
  RgbImage r = picture(1, 0);
  r.rgb[5] = std::nanf("");
  RgbImage x = r;
  x.rgb[3] = x.rgb[4] = x.rgb[5] = 1000;
  const StudyError error = ReferencePicture(r).measure(x);
  EXPECT_EQ(error.mse, 0);
  EXPECT_EQ(error.signed_bias, 0);
}

TEST(NeymanLimit, ClosedForms) {
  const std::vector<double> even(8, 2.0);
  EXPECT_DOUBLE_EQ(neyman_limit(even, even), 1);
  EXPECT_DOUBLE_EQ(neyman_limit(std::vector<double>(8, 0.0), even), 1);
  // A quarter of the pixels has all of the variance, so the limit is 4.
  const std::vector<double> quarter = {4, 0, 0, 0, 4, 0, 0, 0};
  EXPECT_NEAR(neyman_limit(quarter, even), 4, 1e-12);
  // Only the costs are unequal: mean(v) = 1, mean(c) = 2.5, mean(sqrt(v c)) = 1.5.
  EXPECT_NEAR(neyman_limit(std::vector<double>{1, 1}, std::vector<double>{1, 4}), 2.5 / 2.25,
              1e-12);
}

// An exhaustive search finds the best allocation for errors v / n^a. The limit equals the gain of
// this allocation over equal samples, and so also holds for stratified samples.
TEST(NeymanLimit, IsTheLeastErrorOfAnyAllocation) {
  const std::vector<double> v = {1, 9, 4}, c = {2, 1, 5};
  for (const double a : {1.0, 1.5, 2.0}) {
    const auto error = [&](size_t i, double share) { return v[i] * std::pow(c[i] / share, a); };
    double least = 1e30;
    for (double s = 0.01; s < 0.98; s += 0.005) {  // shares of a total cost of 1
      for (double t = 0.01; s + t < 0.99; t += 0.005) {
        least = std::min(least, error(0, s) + error(1, t) + error(2, 1 - s - t));
      }
    }
    const double uniform = (v[0] + v[1] + v[2]) * std::pow(c[0] + c[1] + c[2], a);
    EXPECT_NEAR(neyman_limit(v, c, a), std::pow(uniform / least, 1 / a), 1e-3) << a;
  }
}

TEST(NeymanLimit, MetricsWeighTheVariance) {
  // The two pixels have equal variance, one dark and one bright. Only for mse do they count the
  // same.
  RgbImage mean{2, 1, {0.1f, 0.1f, 0.1f, 2.0f, 2.0f, 2.0f}};
  const std::vector<float> variance(6, 0.5f), seconds(2, 1e-6f);
  const NeymanLimits limits = neyman_limits(variance, seconds, mean, 0.01);
  EXPECT_NEAR(limits.mse, 1, 1e-9);
  const double w0 = 1 / 0.02, w1 = 1 / 4.01;
  EXPECT_NEAR(limits.rel_mse, 2 * (w0 + w1) / std::pow(std::sqrt(w0) + std::sqrt(w1), 2), 1e-4);
  // Beyond white the curve is flat. Its slope is .02, compared with 1.48 at 0.1.
  const double slope = 1.055 / 2.4 * std::pow(0.1, 1 / 2.4 - 1), flat = 0.02;
  EXPECT_NEAR(limits.display, 2 * (slope * slope + flat * flat) / std::pow(slope + flat, 2), 2e-3);
}

}  // namespace
}  // namespace emberline
