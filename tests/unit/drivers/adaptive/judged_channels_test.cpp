// Tests how the errors of several channels decide together, on films whose errors are known.
#include "renderer/drivers/adaptive/judged_channels.h"

#include <gtest/gtest.h>

#include <cmath>

#include "renderer/core/hash.h"
#include "renderer/drivers/adaptive/error_estimator.h"
#include "renderer/film/film.h"

namespace emberline {
namespace {

constexpr int kSide = 64;
constexpr double kVariance = 0.25, kAlbedoVariance = 0.125 * 0.875;

// A film whose samples have an alpha that is 1 in one of two samples. A quarter of the samples hit
// a surface. Its albedo and ambient occlusion are 1 in one of two hits; albedo is 0 where nothing
// is hit. So the variance of a sample is kVariance for alpha and kAlbedoVariance for albedo.
class NoisyFilm {
 public:
  NoisyFilm() : film_(AovSet::parse("albedo,ao"), {.squares = true, .rays = true}) {
    film_.reset({0, 0, kSide, kSide});
  }
  // Adds samples up to `count`, and updates the channels' errors.
  void add_until(uint32_t count, JudgedChannels& judged) {
    for (; samples_ < count; ++samples_) {
      for (int i = 0; i < kSide * kSide; ++i) add_sample(i);
    }
    gather_statistics(film_, &statistics_);
    if (!halves_) halves_.emplace(SampleParts::kPowersOfTwo, judged.value_count());
    halves_->update(&statistics_,
                    [&](size_t i, float* means) { judged.read_means(film_, i, means); });
    errors_.error.assign(statistics_.size(), picture_error_);
    errors_.deviation.assign(statistics_.size(), picture_error_ * std::sqrt(float(count)));
    judged.update(film_, statistics_, *halves_, &errors_);
  }
  void set_picture_error(float error) { picture_error_ = error; }
  double rms_error() const { return rms(errors_.error); }
  double rms_deviation() const { return rms(errors_.deviation); }

 private:
  void add_sample(int i) {
    const auto bit = [&](uint32_t dimension) {
      return (hash32(hash_combine(hash_combine(hash32(uint32_t(i)), samples_), dimension)) & 1u) !=
             0;
    };
    SampleValue value;
    value.alpha = bit(0) ? 1.0f : 0.0f;
    value.first_hit.albedo = Rgb(bit(1) ? 1.0f : 0.0f);
    value.first_hit.hit = bit(2) && bit(3);
    value.first_hit.ambient_visibility = bit(4) ? 1.0f : 0.0f;
    ASSERT_TRUE(film_.add(i % kSide, i / kSide, {.value = value}));
  }
  static double rms(const std::vector<float>& values) {
    double sum = 0;
    for (const float value : values) sum += double(value) * double(value);
    return std::sqrt(sum / double(values.size()));
  }

  FilmTile film_;
  uint32_t samples_ = 0;
  float picture_error_ = 0;
  PixelStatistics statistics_;
  std::optional<SampleHalves> halves_;
  ErrorMap errors_;
};

JudgedChannels judged(const char* list, float threshold) {
  return {parse_judged(list), threshold, -1};
}

// Over 64 x 64 pixels, each with a difference of two means, the mean square is within 10 % of the
// variance with a probability of more than 1 - 1e-5.
TEST(JudgedChannels, ErrorsAreThoseOfTheSamples) {
  for (const auto& [name, variance] :
       {std::pair("A", kVariance), std::pair("albedo", kAlbedoVariance)}) {
    JudgedChannels channels = judged(name, 0.01f);
    NoisyFilm film;
    for (const uint32_t count : {8u, 16u, 32u, 64u}) film.add_until(count, channels);
    EXPECT_NEAR(film.rms_error() / std::sqrt(variance / 64), 1, 0.05) << name;
    EXPECT_NEAR(film.rms_deviation() / std::sqrt(variance), 1, 0.05) << name;
  }
}

// A quarter of the samples hit a surface. The error of their mean is twice as large as that of all
// samples, but counts in proportion to the coverage.
TEST(JudgedChannels, ErrorsOfMeansOverHitsCountByTheCoverage) {
  JudgedChannels channels = judged("ao", 0.01f);
  NoisyFilm film;
  for (const uint32_t count : {64u, 128u, 256u}) film.add_until(count, channels);
  const double expected = std::sqrt(kVariance / (256 / 4)) / 4;
  EXPECT_NEAR(film.rms_error(), expected, 0.1 * expected);
}

TEST(JudgedChannels, ThresholdsScaleErrorsToThatOfTheFrame) {
  JudgedChannels once = judged("A", 0.01f), twice = judged("A:0.005", 0.01f);
  NoisyFilm a, b;
  for (const uint32_t count : {8u, 16u}) {
    a.add_until(count, once);
    b.add_until(count, twice);
  }
  EXPECT_NEAR(b.rms_error(), 2 * a.rms_error(), 1e-5);
  EXPECT_NEAR(b.rms_deviation(), 2 * a.rms_deviation(), 1e-5);
}

TEST(JudgedChannels, TheChannelFurthestFromItsThresholdDecides) {
  JudgedChannels channels = judged("RGB,A,albedo:0.02", 0.01f);
  NoisyFilm film;
  film.set_picture_error(1.0f);
  film.add_until(8, channels);
  EXPECT_EQ(channels.last_unfinished(0), 0u);  // nothing is known of the others
  film.add_until(16, channels);
  EXPECT_EQ(channels.last_unfinished(0), 0u);
  film.set_picture_error(0.0f);
  film.add_until(32, channels);
  EXPECT_EQ(channels.last_unfinished(0), 1u);  // A, since the threshold of albedo is higher
  // The deviations of all channels add up; the scale of albedo is 1/2.
  EXPECT_NEAR(film.rms_deviation(), std::sqrt(kVariance + kAlbedoVariance / 4), 0.03);
}

TEST(JudgedChannels, WithoutTwoPartsNothingIsKnown) {
  JudgedChannels channels = judged("A", 0.01f);
  NoisyFilm film;
  film.add_until(8, channels);
  EXPECT_GT(film.rms_error(), 1e5);
  EXPECT_EQ(film.rms_deviation(), 0);
}

TEST(JudgedChannels, RgbAloneIsTheDefault) {
  EXPECT_TRUE(judged("RGB", 0.01f).is_default());
  EXPECT_TRUE(judged("RGB,light.*", 0.01f).is_default());  // without light groups
  EXPECT_FALSE(judged("RGB:0.02", 0.01f).is_default());
  EXPECT_FALSE(judged("A", 0.01f).is_default());
  EXPECT_EQ(judged_bytes_per_pixel(parse_judged("RGB,A,albedo"), -1), 4u * 8);
  EXPECT_EQ(judged_bytes_per_pixel(parse_judged("light.*"), 5), 5u * 3 * 8);
}

}  // namespace
}  // namespace emberline
