// Tests how a pixel's variance is estimated from two successive means: the arithmetic on synthetic
// numbers, and the identity behind `nested` on the sampler itself.
#include "renderer/drivers/adaptive/sample_halves.h"

#include <gtest/gtest.h>

#include <functional>
#include <vector>

#include "renderer/core/moments.h"
#include "samplers/sampler.h"
#include "unit/synthetic_pixels.h"

namespace emberline {
namespace {

using namespace test;

// One pixel. add() gives it `count` samples with the given mean.
class Pixel {
 public:
  explicit Pixel(SampleParts parts) : halves_(parts), statistics_(constant_pixels(1, 1, 0, 0)) {}
  void add(float count, double mean) {
    sum_ += double(count) * mean;
    count_ += count;
    statistics_.count[0] = count_;
    for (auto& plane : statistics_.mean) plane[0] = float(sum_ / double(count_));
    halves_.update(&statistics_);
  }
  float difference() const { return statistics_.stream_difference[1][0]; }
  float second() const { return statistics_.second_count[0]; }
  // The variance of a sample, computed from two streams as the estimators do.
  double variance() const {
    return square(double(difference())) * double(count_ - second()) * double(second()) /
           double(count_);
  }

 private:
  SampleHalves halves_;
  PixelStatistics statistics_;
  double sum_ = 0;
  float count_ = 0;
};

TEST(SampleHalves, TheSecondLooksSamplesAreTheSecondHalf) {
  Pixel pixel(SampleParts::kPowersOfTwo);
  pixel.add(8, 1);
  EXPECT_EQ(pixel.second(), 0.0f);
  EXPECT_EQ(pixel.difference(), 0.0f);
  pixel.add(8, 3);
  EXPECT_EQ(pixel.second(), 8.0f);
  EXPECT_FLOAT_EQ(pixel.difference(), -2.0f);  // the means are 1 and 3
  pixel.add(16, 7);
  EXPECT_EQ(pixel.second(), 16.0f);
  EXPECT_FLOAT_EQ(pixel.difference(), -5.0f);  // the means are 2 and 7
}

TEST(SampleHalves, KeepsTheLastDifferenceBetweenSteps) {
  Pixel pixel(SampleParts::kPowersOfTwo);
  pixel.add(16, 1);
  pixel.add(16, 3);
  const double before = pixel.variance();
  EXPECT_NEAR(before, 4.0 * 8, 1e-5);
  pixel.add(8, 100);
  EXPECT_NEAR(pixel.variance(), before, 1e-4);
  // At 48 samples the parts are compared again: the first 32 have the mean 2, the next 16 the mean
  // 62.
  pixel.add(8, 24);
  EXPECT_NEAR(pixel.variance(), 60.0 * 60 * 32 * 16 / 48, 1);
}

TEST(SampleHalves, HasNoPartBelowAStratifiedBlock) {
  Pixel pixel(SampleParts::kPowersOfTwo);
  for (int i = 0; i < 3; ++i) pixel.add(4, i);
  EXPECT_EQ(pixel.second(), 0.0f) << "8, and 4 more";
}

// The samples are independent and come in steps of any size. With 20000 pixels and four standard
// errors, false alarms occur for 6e-5 of all seeds.
TEST(SampleHalves, TheirDifferenceIsTheVarianceOfASample) {
  const std::vector<std::vector<float>> looks = {{8, 8},     {8, 24},      {16, 8},
                                                 {16, 8, 8}, {32, 16, 16}, {32, 32, 8}};
  for (const SampleParts parts : {SampleParts::kPowersOfTwo, SampleParts::kEveryUpdate}) {
    for (size_t l = 0; l < looks.size(); ++l) {
      Moments variances;
      for (uint64_t seed = 0; seed < 20000; ++seed) {
        TestRandom random(l, seed);
        Pixel pixel(parts);
        for (const float count : looks[l]) {
          double sum = 0;
          for (int k = 0; k < int(count); ++k) sum += random.next_double();
          pixel.add(count, sum / double(count));
        }
        variances.add(pixel.variance());
      }
      EXPECT_NEAR(variances.mean(), 1.0 / 12, 4 * variances.standard_error()) << "looks " << l;
    }
  }
}

// Let M be the mean of n samples of one stream, and M1 the mean of their first half. E (M1 - M)^2 =
// V(n/2) - V(n) holds if E (M1 - M) (M - mu) = 0, which is tested with 20000 pixels and four
// standard errors. With even and odd samples instead of halves, the pixel's own pair would be off
// by hundreds of standard errors.
TEST(SampleHalves, TheSamplersHalvesAreNested) {
  struct Integrand {
    const char* name;
    double mean;
    std::function<double(double, double, double, double)> value;
  };
  const Integrand integrands[] = {
      {"smooth in the pixel", 0.25, [](double x, double y, double, double) { return x * y; }},
      {"edge in the pixel", 0.5,
       [](double x, double y, double, double) { return x + 0.4 * y < 0.7 ? 1.0 : 0.0; }},
      {"smooth off the camera", 0.25, [](double, double, double u, double v) { return u * v; }},
      {"product", 0.0625, [](double x, double y, double u, double v) { return x * y * u * v; }}};
  const auto sampler = create_sampler("sobol", {});
  constexpr uint32_t kPixelsTried = 20000;
  for (const Integrand& f : integrands) {
    for (const uint32_t n : {16u, 32u, 64u}) {
      Moments products;
      Moments half, whole;
      for (uint32_t p = 0; p < kPixelsTried; ++p) {
        double sums[2] = {0, 0};
        for (uint32_t first = 0; first < n; first += kSampleLanes) {
          SlotBlock camera, surface;
          sampler->fill({p, 3, 9}, 0, first, kSampleLanes, camera, kSlotDimensions);
          sampler->fill({p, 3, 9}, 1, first, kSampleLanes, surface, kSlotDimensions);
          for (uint32_t i = 0; i < uint32_t(kSampleLanes); ++i) {
            sums[first + i < n / 2 ? 0 : 1] +=
                f.value(double(camera.values[0][i]), double(camera.values[1][i]),
                        double(surface.values[2][i]), double(surface.values[3][i]));
          }
        }
        const double first = sums[0] / (n / 2) - f.mean, mean = (sums[0] + sums[1]) / n - f.mean;
        products.add((first - mean) * mean);
        half.add(first * first);
        whole.add(mean * mean);
      }
      EXPECT_NEAR(products.mean(), 0.0, 4 * products.standard_error()) << f.name << ", n " << n;
      EXPECT_GT(half.mean(), 1.5 * whole.mean()) << f.name << ", n " << n;
    }
  }
}

}  // namespace
}  // namespace emberline
