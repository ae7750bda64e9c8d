// Where the planner sends samples if counts go by powers of two (`nested`), on frames whose samples
// are made up.
#include <gtest/gtest.h>

#include <bit>

#include "unit/planned_frames.h"

namespace emberline {
namespace {

using namespace test;
using Sample = SyntheticFrame::Sample;

AdaptiveSettings nested_of_budget(uint32_t budget) {
  AdaptiveSettings s = of_budget(budget);
  s.estimator = "nested";
  return s;
}

// Where one pixel is like another, a power of two is shared out evenly, so that the frame is a
// uniform one but for a few pixels: error x samples, mean(1 / n) mean(n), stays within a hundredth
// of its least, and within three where pixels' estimates differ by their noise.
TEST(RoundPlannerOfDoublings, WhereNothingIsToGainNothingIsLost) {
  for (const bool noise : {false, true}) {
    for (const uint32_t budget : {16u, 32u, 128u, 512u}) {
      SyntheticFrame frame =
          noise ? even_noise(64, 64, 2) : SyntheticFrame(64, 64, 2, [](int, int, TestRandom&) {
            return Sample{0.5f, 2};
          });
      RoundPlanner planner(nested_of_budget(budget), 64, 64, 7);
      frame.render(planner);
      double inverse = 0;
      for (const uint32_t n : frame.counts()) {
        ASSERT_TRUE(std::has_single_bit(n)) << n;
        inverse += 1.0 / n / (64 * 64);
      }
      EXPECT_NEAR(frame.mean_count(), budget, 0.01 * budget) << noise;
      EXPECT_LT(inverse * frame.mean_count(), noise ? 1.03 : 1.01) << noise << ", " << budget;
    }
  }
}

TEST(RoundPlannerOfDoublings, OtherBudgetsAreMixed) {
  for (const uint32_t budget : {20u, 48u, 100u}) {
    SyntheticFrame frame = even_noise(64, 64, 3);
    RoundPlanner planner(nested_of_budget(budget), 64, 64, 7);
    frame.render(planner);
    EXPECT_NEAR(frame.mean_count(), budget, 0.02 * budget);
    EXPECT_LE(frame.mean_count(), budget + 0.1);
  }
}

// As the share that goes to every pixel, whatever is known, does for the default.
TEST(RoundPlannerOfDoublings, PixelsThatSeemFinishedGetTheirShare) {
  EXPECT_NEAR(samples_beside_noise(nested_of_budget(256)), 16 + 24, 6);
}

// Rounds to the nearest power of two spread the ratio of two deviations, 4, over 2.8 to 5.7.
TEST(RoundPlannerOfDoublings, TheSamplesFollowTheDeviation) {
  const double ratio = counts_at_four_times_the_noise(nested_of_budget(400));
  EXPECT_GT(ratio, 2.7);
  EXPECT_LT(ratio, 5.8);
}

// Under a threshold alone there are steps in between, and no more is spent than the default spends.
TEST(RoundPlannerOfDoublings, AThresholdIsMetAndNotMuchMore) {
  AdaptiveSettings s;
  s.estimator = "nested";
  s.threshold = 0.005f;
  const double spent = spent_over_needed(s);
  EXPECT_GT(spent, 0.9);
  EXPECT_LT(spent, 1.6);
}

}  // namespace
}  // namespace emberline
