// Decisions of stochastic coverage are stratified over a pixel's samples. They are independent
// between surfaces and of the sample's other numbers.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>

#include "samplers/pixel_samples.h"

namespace emberline {
namespace {

constexpr uint32_t kSampleCount = 64, kPixelCount = 4096;

struct Decision {
  float first, second;  // of two surfaces that the camera ray hits
  float pixel_x, pixel_y;
};

// The mean and variance, over pixels, of the number of samples out of 64 that `counted` accepts.
struct Count {
  double mean = 0.0, variance = 0.0;
};
Count count(const std::string& sampler_name, StreamCount streams,
            const std::function<bool(const Decision&)>& counted, uint32_t seed) {
  const auto sampler = create_sampler(
      sampler_name,
      {.streams = streams, .samples_per_pixel = kSampleCount, .width = 64, .height = 64});
  PixelSamples samples(*sampler);
  double sum = 0, squares = 0;
  for (uint32_t pixel = 0; pixel < kPixelCount; ++pixel) {
    int n = 0;
    for (uint32_t first = 0; first < kSampleCount; first += kSampleLanes) {
      samples.start_batch({pixel % 64, pixel / 64, seed}, first, kSampleLanes);
      for (int i = 0; i < kSampleLanes; ++i) {
        samples.start_sample(i);
        const float x = samples.get(camera_dim::kPixelX), y = samples.get(camera_dim::kPixelY);
        const CoverageKey key = samples.coverage_key();
        n += counted(
            {CoverageNumbers(key, 3, 7).decision(), CoverageNumbers(key, 3, 8).decision(), x, y});
      }
    }
    sum += n;
    squares += double(n) * n;
  }
  const double mean = sum / kPixelCount;
  return {mean, squares / kPixelCount - mean * mean};
}

// Expects the mean to be `expected` within 4.5 standard errors. One in 150,000 comparisons is a
// false alarm.
void expect_mean(const Count& c, double expected, const std::string& what) {
  EXPECT_NEAR(c.mean, expected, 4.5 * std::sqrt(c.variance / kPixelCount) + 1e-9) << what;
}

const char* const kStratified[] = {"sobol", "stratified", "poisson_disk", "hierarchical",
                                   "blue_noise"};

TEST(CoverageKey, APaneIsThereAsOftenAsItShouldBe) {
  const auto quarter = [](const Decision& d) { return d.first < 0.25f; };
  const auto third = [](const Decision& d) { return d.first < 0.3f; };
  for (const char* name : kStratified) {
    for (const StreamCount streams : {StreamCount::kOne, StreamCount::kTwo}) {
      const Count exact = count(name, streams, quarter, 1);
      EXPECT_EQ(exact.mean, 16) << name;
      EXPECT_EQ(exact.variance, 0) << name;
      const Count nearly = count(name, streams, third, 2);
      expect_mean(nearly, 0.3 * kSampleCount, name);
      EXPECT_LT(nearly.variance, 0.51) << name;  // one stratum per stream is cut; 13.4 if random
    }
  }
  const Count chance = count("independent", StreamCount::kOne, quarter, 3);
  expect_mean(chance, 16, "independent");
  EXPECT_NEAR(chance.variance, 12, 4.5 * 12 * std::sqrt(2.0 / kPixelCount));
}

// Decisions are also independent of the stratified position in the pixel, and of the half that it
// is in.
TEST(CoverageKey, SurfacesAndPlacesAreIndependent) {
  const auto both = [](const Decision& d) { return d.first < 0.5f && d.second < 0.25f; };
  const auto either_half = [](const Decision& d) { return (d.first < 0.5f) == (d.pixel_x < 0.5f); };
  const auto corner = [](const Decision& d) {
    return d.first < 0.5f && d.pixel_x < 0.25f && d.pixel_y < 0.5f;
  };
  const auto same = [](const Decision& d) { return (d.first < 0.5f) == (d.second < 0.5f); };
  const auto near_by = [](const Decision& d) { return std::abs(d.first - d.second) < 0.125f; };
  for (const char* name : kStratified) {
    const Count b = count(name, StreamCount::kOne, both, 4);
    expect_mean(b, kSampleCount / 8.0, name);
    EXPECT_LT(b.variance, 1.1 * 64 * (1 / 8.0) * (7 / 8.0)) << name;
    const Count e = count(name, StreamCount::kOne, either_half, 5);
    expect_mean(e, kSampleCount / 2.0, name);
    EXPECT_LT(e.variance, 1.3 * 64 / 4.0) << name;  // blocks of 8 raise it to 8/7 of 64 / 4
    const Count c = count(name, StreamCount::kOne, corner, 6);
    expect_mean(c, kSampleCount / 16.0, name);
    const Count s = count(name, StreamCount::kOne, same, 7);
    expect_mean(s, kSampleCount / 2.0, name);
    EXPECT_LT(s.variance, 1.3 * 64 / 4.0) << name;
    const Count n = count(name, StreamCount::kOne, near_by, 8);
    expect_mean(n, kSampleCount * (1 - 0.875 * 0.875), name);
    EXPECT_LT(n.variance, 1.3 * 64 * 0.234375 * 0.765625) << name;
  }
}

// Two streams are two estimates, so their difference gives the error of their mean.
TEST(CoverageKey, StreamsAreIndependent) {
  const auto sampler = create_sampler("sobol", {.streams = StreamCount::kTwo});
  PixelSamples samples(*sampler);
  double products = 0, squares = 0;
  for (uint32_t pixel = 0; pixel < kPixelCount; ++pixel) {
    double off[2] = {-0.3 * 8, -0.3 * 8};
    samples.start_batch({pixel, 5, 9}, 0, kSampleLanes);
    for (int i = 0; i < kSampleLanes; ++i) {
      samples.start_sample(i);
      off[i >> 3] += CoverageNumbers(samples.coverage_key(), 1, 1).decision() < 0.3f;
    }
    products += off[0] * off[1];
    squares += off[0] * off[0];
  }
  EXPECT_NEAR(products / squares, 0, 4.5 / std::sqrt(double(kPixelCount)));
}

}  // namespace
}  // namespace emberline
