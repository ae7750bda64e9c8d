// Tests how the planner allocates samples on synthetic frames if counts go by steps, as for
// `nested`. The steps are the powers of two and 1.5 times these.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "renderer/core/archive.h"
#include "unit/planned_frames.h"

namespace emberline {
namespace {

using namespace test;
using Sample = SyntheticFrame::Sample;

AdaptiveSettings nested_budget_settings(uint32_t budget) {
  AdaptiveSettings s = budget_settings(budget);
  s.estimator = "nested";
  return s;
}

// The first half of the pilot is compared with the second.
TEST(RoundPlannerOfSteps, ThePilotComesInTwoHalves) {
  const auto pilots = [](const AdaptiveSettings& s) {
    SyntheticFrame frame = even_noise(8, 8, 1);
    RoundPlanner planner(s, 8, 8, 1);
    const uint32_t first = planner.targets()[0];
    frame.add_samples_until(planner.targets());
    planner.plan(frame.film());
    return std::pair(first, std::ranges::min(planner.targets()));
  };
  EXPECT_EQ(pilots(nested_budget_settings(4096)), std::pair(8u, 16u));
  EXPECT_EQ(pilots(nested_budget_settings(64)).first, 8u);
  EXPECT_EQ(pilots(nested_budget_settings(5)).first, 5u);
  AdaptiveSettings s = nested_budget_settings(0);
  s.threshold = 0.01f;
  EXPECT_EQ(pilots(s), std::pair(8u, 16u));
  s.min_samples = 64;
  EXPECT_EQ(pilots(s), std::pair(8u, 16u));
}

// A frame with a time budget begins with few samples per pixel, because it may be short. If the
// time allows many samples, all pixels get the larger pilot first.
TEST(RoundPlannerOfSteps, AnOpenBudgetGrowsThePilot) {
  for (const bool resumed : {false, true}) {
    for (const auto& [factor, expected] : {std::pair(1.5, 12u), std::pair(40.0, 16u)}) {
      AdaptiveSettings s = nested_budget_settings(8);
      s.is_open = true;
      SyntheticFrame frame = even_noise(32, 32, 1);
      RoundPlanner planner(s, 32, 32, 1);
      for (const uint32_t count : {2u, 4u, 8u}) {
        EXPECT_EQ(std::ranges::minmax(planner.targets()).max, count);
        frame.add_samples_until(planner.targets());
        EXPECT_EQ(planner.plan(frame.film()), count < 8) << "the budget is only the pilot";
      }
      planner.extend_work(factor);
      RoundPlanner other(s, 32, 32, 1);
      if (resumed) {
        std::vector<std::byte> state;
        Archive saving(state);
        planner.archive(saving);
        Archive loading(std::span<const std::byte>{state});
        other.archive(loading);
      }
      RoundPlanner& next = resumed ? other : planner;
      ASSERT_TRUE(next.plan(frame.film()));
      const auto [least, most] = std::ranges::minmax(next.targets());
      EXPECT_EQ(least, expected) << factor << " without a larger pilot, steps of 1.5 are possible";
      EXPECT_LE(most, 16u) << factor;
    }
  }
}

// If all pixels are alike, a budget that is a power of two is allocated evenly, so that the frame
// is uniform except for few pixels. The product of error and samples, mean(1 / n) mean(n), stays
// within a hundredth of its minimum, or within three hundredths where the pixels' estimates are
// noisy.
TEST(RoundPlannerOfSteps, WhereNothingIsToGainNothingIsLost) {
  for (const bool noise : {false, true}) {
    for (const uint32_t budget : {16u, 32u, 128u, 512u}) {
      SyntheticFrame frame =
          noise ? even_noise(64, 64, 2) : SyntheticFrame(64, 64, 2, [](int, int, TestRandom&) {
            return Sample{0.5f, 2};
          });
      RoundPlanner planner(nested_budget_settings(budget), 64, 64, 7);
      frame.render(planner);
      double inverse = 0;
      for (const uint32_t n : frame.counts()) {
        ASSERT_TRUE(std::has_single_bit(n) || (n % 3 == 0 && std::has_single_bit(n / 3))) << n;
        inverse += 1.0 / n / (64 * 64);
      }
      EXPECT_NEAR(frame.mean_count(), budget, 0.01 * budget) << noise;
      EXPECT_LT(inverse * frame.mean_count(), noise ? 1.03 : 1.01) << noise << ", " << budget;
    }
  }
}

// A round reads every pixel. So the planner starts none for the small rest of the budget that the
// steps leave.
TEST(RoundPlannerOfSteps, NoRoundIsForCrumbs) {
  for (const uint32_t budget : {32u, 128u, 512u}) {
    for (const uint64_t seed : {2, 3, 4}) {
      SyntheticFrame frame = even_noise(64, 64, seed);
      RoundPlanner planner(nested_budget_settings(budget), 64, 64, 7);
      double least_left = budget;
      frame.render(planner,
                   [&] { least_left = std::min(least_left, budget - frame.mean_count()); });
      EXPECT_GE(least_left, budget / 500.0) << budget;
      EXPECT_GE(frame.mean_count(), 0.99 * budget) << budget;
    }
  }
}

TEST(RoundPlannerOfSteps, OtherBudgetsAreMixed) {
  for (const uint32_t budget : {20u, 48u, 100u}) {
    SyntheticFrame frame = even_noise(64, 64, 3);
    RoundPlanner planner(nested_budget_settings(budget), 64, 64, 7);
    frame.render(planner);
    EXPECT_NEAR(frame.mean_count(), budget, 0.02 * budget);
    EXPECT_LE(frame.mean_count(), budget + 0.1);
  }
}

// The uniform share is the same as with the default estimator.
TEST(RoundPlannerOfSteps, PixelsThatSeemFinishedGetTheirShare) {
  EXPECT_NEAR(noiseless_samples(nested_budget_settings(256)), 16 + 24, 6);
}

// The deviations have a ratio of 4. The rounding of counts to steps spreads the ratio over 3 to
// 5.3.
TEST(RoundPlannerOfSteps, TheSamplesFollowTheDeviation) {
  const double ratio = sample_ratio_by_noise(nested_budget_settings(400));
  EXPECT_GT(ratio, 2.9);
  EXPECT_LT(ratio, 5.4);
}

TEST(RoundPlannerOfSteps, DearSamplesAreFewer) {
  const double expected = std::sqrt(8.17 / 1.17);
  const double ratio = sample_ratio_by_cost(nested_budget_settings(400));
  EXPECT_GT(ratio, 0.75 * expected);
  EXPECT_LT(ratio, 1.1 * expected);
}

// The three channels have a deviation of .1. Later samples correct overestimates but not
// underestimates, so the mean is somewhat low.
TEST(RoundPlannerOfSteps, TheVarianceIsSeen) {
  SyntheticFrame frame = even_noise(48, 48, 3);
  RoundPlanner planner(nested_budget_settings(400), 48, 48, 5);
  frame.render(planner);
  double mean = 0;
  for (const float d : planner.errors().deviation) mean += double(d) * double(d) / (48 * 48);
  EXPECT_GT(mean, 0.8 * 0.01);
  EXPECT_LT(mean, 1.05 * 0.01);
}

// With a threshold alone there are intermediate steps, and the threshold costs no more than with
// the default estimator.
TEST(RoundPlannerOfSteps, AThresholdIsMetAndNotMuchMore) {
  AdaptiveSettings s;
  s.estimator = "nested";
  s.threshold = 0.005f;
  const double spent = spent_to_needed_ratio(s);
  EXPECT_GT(spent, 0.9);
  EXPECT_LT(spent, 1.6);
}

// One half has four times the deviation of the other. A plan for any budget gives it four times the
// samples, within the steps between counts.
TEST(RoundPlannerOfSteps, PlannedCountsFollowTheDeviations) {
  SyntheticFrame frame(96, 48, 13, [](int x, int, TestRandom& random) {
    return noisy(random, 0.4f, x < 48 ? 0.03f : 0.12f);
  });
  const AdaptiveSettings pilot = nested_budget_settings(32);
  RoundPlanner planner(pilot, 96, 48, 5);
  EXPECT_TRUE(planner.planned_counts(pilot).empty());
  frame.render(planner);
  for (const uint32_t budget : {64u, 256u, 1000u}) {
    AdaptiveSettings limits = pilot;
    limits.budget = budget;
    const std::vector<uint32_t> counts = planner.planned_counts(limits);
    ASSERT_EQ(counts.size(), 96u * 48);
    double quiet = 0, loud = 0;
    for (size_t i = 0; i < counts.size(); ++i) {
      (i % 96 < 48 ? quiet : loud) += counts[i];
      ASSERT_GE(counts[i], std::max(8u, budget / 16));
      ASSERT_LE(counts[i], 16 * frame.counts()[i]);
    }
    const double mean = (quiet + loud) / double(counts.size());
    const bool is_limited = budget == 1000;  // 16 times the loud half's samples of the pilot
    EXPECT_LE(mean, 1.002 * budget);
    EXPECT_GE(mean, (is_limited ? 0.5 : 0.9) * budget);
    EXPECT_NEAR(loud / quiet, 4.0, 1.0) << budget;
  }
  // A denoised frame needs samples in both halves of eight.
  AdaptiveSettings halves = pilot;
  halves.two_halves = true;
  EXPECT_GE(std::ranges::min(planner.planned_counts(halves)), 16u);
  // A threshold needs n (error / threshold)^2 samples.
  AdaptiveSettings limits = pilot;
  limits.budget = 0;
  limits.threshold = 1e-3f;
  limits.max_samples = 4096;
  const std::vector<uint32_t> counts = planner.planned_counts(limits);
  double ratio = 0;
  for (size_t i = 0; i < counts.size(); ++i) {
    const double error = planner.errors().error[i] / 1e-3;
    const double needed = frame.counts()[i] * error * error;
    ratio += counts[i] / std::clamp(needed, 8.0, std::min(4096.0, 16.0 * frame.counts()[i]));
  }
  EXPECT_NEAR(ratio / double(counts.size()), 1.1, 0.1);
}

}  // namespace
}  // namespace emberline
