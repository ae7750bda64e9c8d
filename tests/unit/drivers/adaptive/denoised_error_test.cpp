// Tests --allocation denoised on synthetic frames. Pixels that the filter can clean need no
// samples.
#include "renderer/drivers/adaptive/denoised_error.h"
#include "renderer/core/archive.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <vector>

#include "renderer/core/errors.h"
#include "unit/planned_frames.h"

namespace emberline {
namespace {

using namespace test;

constexpr int kWidth = 64, kHeight = 48;

// The noise is the same everywhere. The left half is flat. In the right half each pixel has a
// random brightness, which its neighbours and features cannot predict.
SyntheticFrame half_flat(uint64_t seed) {
  return {kWidth, kHeight, seed, [](int x, int y, TestRandom& random) {
            TestRandom of_pixel(77, uint64_t(y) * kWidth + uint64_t(x));
            const float mean = x < kWidth / 2 ? 0.5f : 0.3f + 0.4f * of_pixel.next();
            return noisy(random, mean, 0.1f);
          }};
}

// The number of samples in the right half, divided by the number in the left half.
double rough_half_samples(std::string_view estimator, ErrorMetric allocation) {
  SyntheticFrame frame = half_flat(5);
  AdaptiveSettings settings = budget_settings(256, allocation);
  settings.estimator = estimator;
  RoundPlanner planner(settings, kWidth, kHeight, 7);
  frame.render(planner);
  EXPECT_NEAR(frame.mean_count(), 256.0, 13.0);
  double left = 0, right = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) (x < kWidth / 2 ? left : right) += frame.count(x, y);
  }
  return right / left;
}

// If noise alone counted, both halves would get equal shares.
TEST(DenoisedError, SamplesGoWhereNoFilterHelps) {
  for (const char* estimator : {"two-stream", "nested"}) {
    SCOPED_TRACE(estimator);
    EXPECT_LT(rough_half_samples(estimator, ErrorMetric::kDisplay), 1.25);
    EXPECT_GT(rough_half_samples(estimator, ErrorMetric::kDenoised), 1.75);
  }
}

struct FilteredFrame {
  SyntheticFrame frame = half_flat(6);
  DenoisedError denoised;
  ErrorMap map = {std::vector<float>(size_t(kWidth) * kHeight, 7.0f),
                  std::vector<float>(size_t(kWidth) * kHeight, 7.0f)};

  void update(uint32_t samples, bool may_filter = true) {
    frame.add_samples_until(std::vector<uint32_t>(size_t(kWidth) * kHeight, samples));
    const std::vector<float> counts(size_t(kWidth) * kHeight, float(samples));
    EXPECT_TRUE(denoised.update(frame.film(), counts, may_filter, &map, {}));
  }
};

TEST(DenoisedError, IsFilteredAtFourTimesTheSamplesAndFallsInBetween) {
  FilteredFrame at;
  at.update(8);
  EXPECT_EQ(at.map.error[0], 7.0f) << "one of the streams has no sample yet";
  at.update(16);
  EXPECT_FALSE(at.denoised.is_stale());
  const std::vector<float> error = at.map.error, deviation = at.map.deviation;
  EXPECT_LT(error[0], 0.5f * error[kWidth - 1]);
  at.update(32);
  EXPECT_TRUE(at.denoised.is_stale());
  EXPECT_EQ(at.map.deviation, deviation);
  for (size_t i = 0; i < error.size(); ++i) {
    ASSERT_NEAR(error[i], 4 * deviation[i] / 16, 1e-6);
    ASSERT_NEAR(at.map.error[i], error[i] / std::sqrt(2.0f), 1e-6);
  }
  at.update(64, false);
  EXPECT_TRUE(at.denoised.is_stale());
  EXPECT_EQ(at.map.deviation, deviation);
  at.update(64);
  EXPECT_FALSE(at.denoised.is_stale());
  EXPECT_NE(at.map.deviation, deviation);
}

// A state that is saved between two passes of the filter resumes to the same bits. A state of
// another size is rejected.
TEST(DenoisedError, ComesBackFromAnArchive) {
  const size_t pixels = size_t(kWidth) * kHeight;
  FilteredFrame at, back;
  at.update(16);
  std::vector<std::byte> bytes;
  Archive saving(bytes);
  at.denoised.archive(saving, pixels);
  saving.end();
  Archive loading{std::span<const std::byte>(bytes)};
  back.denoised.archive(loading, pixels);
  loading.end();
  for (FilteredFrame* one : {&at, &back}) one->update(48);
  EXPECT_TRUE(back.denoised.is_stale());
  EXPECT_EQ(at.map.error, back.map.error);
  Archive other{std::span<const std::byte>(bytes)};
  DenoisedError small;
  EXPECT_THROW(small.archive(other, pixels - 1), InputError);
}

TEST(DenoisedError, TheSameForAnyThreads) {
  std::vector<float> reference;
  for (const int threads : {1, 2, 7}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, size_t(threads));
    tbb::task_arena arena(threads);
    arena.execute([&] {
      FilteredFrame at;
      at.update(16);
      if (reference.empty()) reference = at.map.error;
      EXPECT_EQ(at.map.error, reference) << threads << " threads";
    });
  }
}

// The light ranges from far darker to far brighter than white, and the left half has no noise. The
// budget must hold, and the error must be known.
TEST(DenoisedError, BudgetsHoldInAnyLight) {
  for (const char* estimator : {"two-stream", "nested"}) {
    for (int exponent = -20; exponent <= 20; exponent += 4) {
      SCOPED_TRACE(std::string(estimator) + ", 2^" + std::to_string(exponent));
      const float scale = std::ldexp(1.0f, exponent);
      SyntheticFrame frame(kWidth, kHeight, 9, [scale](int x, int, TestRandom& random) {
        return x < kWidth / 2 ? SyntheticFrame::Sample{scale, 2}
                              : noisy(random, 0.5f * scale, 0.1f * scale);
      });
      AdaptiveSettings settings = budget_settings(64, ErrorMetric::kDenoised);
      settings.estimator = estimator;
      RoundPlanner planner(settings, kWidth, kHeight, 7);
      frame.render(planner);
      EXPECT_LE(frame.mean_count(), 64.8);  // counts are rounded at random
      EXPECT_GT(frame.mean_count(), 58.0);
      EXPECT_TRUE(planner.error_estimate() >= 0.0 && planner.error_estimate() <= 0.5);
      for (const float error : planner.errors().error) ASSERT_TRUE(error >= 0.0f && error <= 0.5f);
    }
  }
}

// A cancelled filter leaves the map unchanged.
TEST(DenoisedError, AStopIsHonoured) {
  FilteredFrame at;
  at.frame.add_samples_until(std::vector<uint32_t>(size_t(kWidth) * kHeight, 16));
  const std::vector<float> counts(size_t(kWidth) * kHeight, 16.0f);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_FALSE(at.denoised.filter(at.frame.film(), counts, &at.map, stop.get_token()));
  EXPECT_EQ(at.map.error[0], 7.0f);
}

}  // namespace
}  // namespace emberline
