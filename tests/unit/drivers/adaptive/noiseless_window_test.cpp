// Tests windows whose first samples show no noise, because there is none or because the samples are
// too few. The frames are synthetic and have a threshold.
#include <gtest/gtest.h>

#include "support/long_tests.h"
#include "unit/planned_frames.h"

namespace emberline {
namespace {

using namespace test;
using Sample = SyntheticFrame::Sample;

// The mean samples of a small crop under a threshold, in which every sample is `rest`.
double samples_without_noise(const Sample& rest, int size, const AdaptiveSettings& settings) {
  SyntheticFrame frame(size, size, 10, [&](int, int, TestRandom&) { return rest; });
  RoundPlanner planner(settings, size, size, 5);
  frame.render(planner);
  return frame.mean_count();
}

TEST(NoiselessWindow, ZeroNoiseNeedsEnoughSamples) {
  for (const char* estimator : {"two-stream", "nested"}) {
    SCOPED_TRACE(estimator);
    AdaptiveSettings s;
    s.estimator = estimator;
    s.threshold = 0.02f;
    const Sample black = {0.0f, 2};
    EXPECT_EQ(samples_without_noise(black, 16, s), 512.0);  // 2^17 samples in the crop
    EXPECT_EQ(samples_without_noise(black, 4, s), 1024.0);  // 64 times the pilot
    EXPECT_EQ(samples_without_noise(black, 128, s), 16.0);  // enough from the start
    EXPECT_EQ(samples_without_noise({0.4f, 3}, 16, s), 512.0);
    // If a camera ray hits nothing or a lamp, no light can be missed.
    EXPECT_EQ(samples_without_noise({0.4f, 1}, 16, s), 16.0);
    s.max_samples = 100;
    EXPECT_EQ(samples_without_noise(black, 16, s), 100.0);
    s.max_samples = 0;
    s.budget = 40;
    EXPECT_EQ(samples_without_noise(black, 16, s), 32.0);  // 64 would be too many
  }
}

// One path in 4000 finds the light, so a quarter of the 16 x 16 windows see none in the pilot. A
// crop misses the light in 2^17 samples with probability e^-32, which is the rate of false alarms.
TEST(NoiselessWindow, RareLightIsIncluded) {
  AdaptiveSettings s;
  s.threshold = 0.05f;
  for (const char* estimator : {"two-stream", "nested"}) {
    s.estimator = estimator;
    for (uint64_t seed = 0; seed < test::long_or_short(40u, 12u); ++seed) {
      SyntheticFrame frame(16, 16, seed, [](int, int, TestRandom& random) {
        return Sample{random.next() < 1.0f / 4000 ? 40.0f : 0.0f, 2};
      });
      RoundPlanner planner(s, 16, 16, 5);
      frame.render(planner);
      double light = 0;
      for (size_t i = 0; i < 256; ++i)
        light += frame.film().sums(i).rgb[0][0] + frame.film().sums(i).rgb[1][0];
      ASSERT_GT(light, 0.0) << estimator << ", seed " << seed;
    }
  }
}

}  // namespace
}  // namespace emberline
