// Tests how the planner allocates samples on synthetic frames. Every decision is made without a
// renderer.
#include "renderer/drivers/adaptive/round_planner.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "support/long_tests.h"
#include "unit/planned_frames.h"
#include "unit/synthetic_pixels.h"

namespace emberline {
namespace {

using namespace test;
using Sample = SyntheticFrame::Sample;

TEST(RoundPlanner, StartsWithThePilot) {
  const auto pilot = [](AdaptiveSettings s) {
    const RoundPlanner planner(s, 5, 4, 1);
    EXPECT_EQ(planner.targets().size(), 20u);
    for (const uint32_t target : planner.targets()) EXPECT_EQ(target, planner.targets()[0]);
    EXPECT_EQ(planner.round_weight(), double(planner.targets()[0]));
    EXPECT_TRUE(std::isnan(planner.error_estimate()));
    return planner.targets()[0];
  };
  // The pilot is an eighth of the budget, limited to 8 to 16 samples and to the budget itself.
  EXPECT_EQ(pilot(budget_settings(1)), 1u);
  EXPECT_EQ(pilot(budget_settings(5)), 5u);
  EXPECT_EQ(pilot(budget_settings(16)), 8u);
  EXPECT_EQ(pilot(budget_settings(64)), 8u);
  EXPECT_EQ(pilot(budget_settings(4096)), 16u);
  AdaptiveSettings s = budget_settings(0);
  s.threshold = 0.01f;
  EXPECT_EQ(pilot(s), 16u);
  s.max_samples = 5;
  EXPECT_EQ(pilot(s), 5u);
  s.max_samples = 0;
  s.min_samples = 33;
  EXPECT_EQ(pilot(s), 33u);
  for (const EstimatorEntry& entry : estimator_table()) {
    if (entry.batch == 0) continue;
    AdaptiveSettings historical = budget_settings(64);
    historical.estimator = entry.name;
    EXPECT_EQ(pilot(historical), entry.first_samples) << entry.name;
  }
}

// All pixels are equal, so none gets more samples than another, except by rounding.
TEST(RoundPlanner, AConstantImageSpendsEvenly) {
  for (const float value : {0.0f, 0.5f, 1e4f}) {
    for (const NamedValue<ErrorMetric>& metric : error_metric_table()) {
      SCOPED_TRACE(std::to_string(value) + ", " + std::string(metric.name));
      SyntheticFrame frame(64, 40, 1, [&](int, int, TestRandom&) { return Sample{value, 1}; });
      RoundPlanner planner(budget_settings(32, metric.value), 64, 40, 7);
      frame.render(planner);
      const auto [least, most] = std::ranges::minmax_element(frame.counts());
      EXPECT_LE(*most - *least, 16u);
      // Black pixels are no reason to stop, because a lamp may be too small for the pilot.
      EXPECT_NEAR(frame.mean_count(), 32.0, 0.064);
      EXPECT_LT(planner.error_estimate(), 1e-6);
      for (size_t i = 0; i < 64 * 40; ++i) ASSERT_EQ(planner.stop_of(i), PixelStop::kBudget);
    }
  }
}

TEST(RoundPlanner, EvenNoiseSpendsAlmostEvenly) {
  SyntheticFrame frame = even_noise(64, 64, 2);
  RoundPlanner planner(budget_settings(64), 64, 64, 7);
  frame.render(planner);
  double squares = 0;
  for (const uint32_t n : frame.counts()) squares += double(n) * n;
  const double mean = frame.mean_count();
  EXPECT_NEAR(mean, 64.0, 0.128);
  // Pooled streams have about 25 degrees of freedom, and rounding to 8 and 16 adds to the spread.
  EXPECT_LT(std::sqrt(squares / (64 * 64) - mean * mean), 0.2 * mean);
}

// The disc is .8 % of the frame. By Neyman's rule it should get everything but the uniform share.
TEST(RoundPlanner, ALoneNoisyDiscGetsTenTimesTheMeanDensity) {
  for (uint64_t seed = 1; seed <= 8; ++seed) {
    for (const uint32_t budget : {16u, 64u}) {
      SyntheticFrame frame(64, 64, seed, [](int x, int y, TestRandom& random) {
        return std::hypot(x - 31.5, y - 20.5) <= 3.0 ? noisy(random, 2.0f, 1.0f) : Sample{0.1f, 2};
      });
      RoundPlanner planner(budget_settings(budget), 64, 64, uint32_t(seed));
      frame.render(planner);
      double disc = 0, pixels = 0;
      for (int y = 0; y < 64; ++y) {
        for (int x = 0; x < 64; ++x) {
          if (std::hypot(x - 31.5, y - 20.5) > 3.0) continue;
          disc += frame.count(x, y);
          ++pixels;
        }
      }
      EXPECT_EQ(pixels, 32);
      EXPECT_GE(disc / pixels, 10.0 * frame.mean_count()) << "seed " << seed << ", " << budget;
      // With a budget of 64, the pixels of the disc get 2000 or more samples, which are rounded at
      // random to multiples of 256. 32 pixels with a deviation of at most 128 each change the mean
      // of 4096 pixels by .7 at four deviations.
      EXPECT_NEAR(frame.mean_count(), budget, budget == 64 ? 0.7 : 0.2);
    }
  }
}

// Up to a tenth of the samples are bright. Pixels that they hit must not drain the budget of the
// others.
TEST(RoundPlanner, BudgetsAreMet) {
  for (const uint32_t budget : {1u, 3u, 16u, 17u, 64u, 200u}) {
    for (const NamedValue<ErrorMetric>& metric : error_metric_table()) {
      SyntheticFrame frame(192, 108, budget, [](int x, int y, TestRandom& random) {
        const float deviation = 0.3f * float(x) / 192.0f;
        return random.next() < 1e-3f * float(y) ? Sample{20.0f, 9} : noisy(random, 0.5f, deviation);
      });
      RoundPlanner planner(budget_settings(budget, metric.value), 192, 108, 11);
      int rounds = 0;
      frame.render(planner, [&] { ++rounds; });
      // Counts are rounded at random to multiples of 8 and 16, which gives .06 at four deviations
      // for 20736 pixels.
      EXPECT_NEAR(frame.mean_count(), budget, std::max(0.002 * budget, 0.1))
          << budget << ", " << metric.name;
      EXPECT_LT(rounds, 40);
      EXPECT_EQ(planner.round(), rounds + 1);
    }
  }
}

// Apart from the uniform share, a round raises a pixel to at most four times its current samples.
TEST(RoundPlanner, GrowthIsBounded) {
  SyntheticFrame frame(48, 48, 3, [](int x, int, TestRandom& random) {
    return noisy(random, 1.0f, x == 24 ? 1.0f : 0.001f);
  });
  RoundPlanner planner(budget_settings(64), 48, 48, 5);
  frame.render(planner, [&] {
    for (size_t i = 0; i < frame.counts().size(); ++i) {
      const double have = std::max(4u, frame.counts()[i]);
      const double uniform = double(frame.counts()[i]) + 0.11 * planner.round_weight();
      ASSERT_LT(planner.targets()[i], std::max(4 * have, uniform) + 16) << "pixel " << i;
      ASSERT_GE(planner.targets()[i], frame.counts()[i]);
    }
  });
}

TEST(RoundPlanner, MostSamplesAreNeverExceeded) {
  for (const EstimatorEntry& entry : estimator_table()) {
    for (const uint32_t most : {1u, 7u, 37u, 100u}) {
      for (const uint32_t budget : {0u, 50u}) {
        SCOPED_TRACE(std::string(entry.name) + ", most " + std::to_string(most));
        SyntheticFrame frame(32, 32, 4, [](int x, int, TestRandom& random) {
          return noisy(random, 1.0f, x < 3 ? 1.0f : 0.01f);
        });
        AdaptiveSettings s = budget_settings(budget);
        s.estimator = entry.name;
        s.max_samples = most;
        RoundPlanner planner(s, 32, 32, 5);
        frame.render(planner);
        for (size_t i = 0; i < frame.counts().size(); ++i) {
          ASSERT_LE(frame.counts()[i], most);
          ASSERT_EQ(planner.stop_of(i),
                    frame.counts()[i] == most ? PixelStop::kMaximum : PixelStop::kBudget);
          // Without a budget, every pixel gets the maximum.
          if (budget == 0) {
            ASSERT_EQ(frame.counts()[i], most);
          }
        }
      }
    }
  }
}

TEST(RoundPlanner, LeastAndMostAlikeIsUniform) {
  for (const EstimatorEntry& entry : estimator_table()) {
    for (const uint32_t n : {1u, 3u, 16u, 37u}) {
      SyntheticFrame frame = even_noise(16, 16, 5);
      AdaptiveSettings s = budget_settings(n);
      s.estimator = entry.name;
      s.min_samples = s.max_samples = n;
      RoundPlanner planner(s, 16, 16, 5);
      frame.render(planner);
      for (const uint32_t count : frame.counts()) ASSERT_EQ(count, n) << entry.name;
    }
  }
}

// A tenth of every round goes to all pixels alike, so that overlooked light is found.
TEST(RoundPlanner, PixelsThatSeemFinishedGetTheirShare) {
  // The pilot has 16 samples, and a tenth of the remaining 240 is shared.
  EXPECT_NEAR(noiseless_samples(budget_settings(256)), 16 + 24, 4);
}

TEST(RoundPlanner, AThresholdEndsPixelsAndNoneAboveItEnds) {
  for (const EstimatorEntry& entry : estimator_table()) {
    SCOPED_TRACE(entry.name);
    SyntheticFrame frame(48, 32, 8, [](int x, int, TestRandom& random) {
      return noisy(random, 0.4f, 0.02f + 0.2f * float(x) / 48.0f);
    });
    AdaptiveSettings s;
    s.estimator = entry.name;
    s.threshold = 0.02f;
    s.max_samples = 1024;  // contrast between neighbours does not fall with samples
    RoundPlanner planner(s, 48, 32, 5);
    frame.render(planner, [&] {
      for (size_t i = 0; i < frame.counts().size(); ++i) {
        if (planner.errors().error[i] > s.threshold && frame.counts()[i] < s.max_samples) {
          ASSERT_GT(planner.targets()[i], frame.counts()[i]) << "pixel " << i << " goes on";
        }
      }
    });
    for (size_t i = 0; i < frame.counts().size(); ++i) {
      if (frame.counts()[i] == s.max_samples) continue;
      ASSERT_LE(planner.errors().error[i], s.threshold) << "pixel " << i;
      ASSERT_EQ(planner.stop_of(i), PixelStop::kThreshold);
    }
    if (entry.batch == 0) {
      EXPECT_LE(planner.error_estimate(), 0.021);  // not pooled, so it has noise of its own
      EXPECT_LT(frame.mean_count(), 100.0);
    }
  }
}

// A threshold costs only the samples that it needs. With these the error, about deviation /
// sqrt(n), just reaches the threshold.
TEST(RoundPlanner, AThresholdIsMetAndNotMuchMore) {
  AdaptiveSettings s;
  s.threshold = 0.005f;
  const double spent = spent_to_needed_ratio(s);
  EXPECT_GT(spent, 0.9);
  EXPECT_LT(spent, 1.5);
}

// While other pixels continue, the planner knows which pixels are finished, although these still
// get the uniform share. At the end it knows the reason for every pixel.
TEST(RoundPlanner, ReportsFinishedPixelsWhileOthersContinue) {
  SyntheticFrame frame(48, 32, 10, [](int x, int, TestRandom& random) {
    return noisy(random, 0.4f, 0.01f * float(x));
  });
  AdaptiveSettings s;
  s.threshold = 0.01f;
  s.max_samples = 200;
  RoundPlanner planner(s, 48, 32, 5);
  ASSERT_EQ(planner.current_stop(0, planner.targets()[0]), PixelStop::kUnfinished)
      << "not looked at";
  size_t mixed = 0;
  frame.render(planner, [&] {
    size_t going_on = 0;
    for (size_t i = 0; i < frame.counts().size(); ++i) {
      const uint32_t have = frame.counts()[i];
      const PixelStop stop = planner.current_stop(i, have);
      const bool good = planner.errors().error[i] <= s.threshold;
      ASSERT_EQ(stop, good          ? PixelStop::kThreshold
                      : have == 200 ? PixelStop::kMaximum
                                    : PixelStop::kUnfinished);
      going_on += stop == PixelStop::kUnfinished;
    }
    mixed += going_on > 0 && going_on < frame.counts().size();
  });
  EXPECT_GT(mixed, 0u);
  for (size_t i = 0; i < frame.counts().size(); ++i) {
    ASSERT_EQ(planner.current_stop(i, frame.counts()[i]), planner.stop_of(i)) << i;
  }
}

TEST(RoundPlanner, NoisyPixelsEndAtMaxSpp) {
  SyntheticFrame frame(32, 32, 10, [](int x, int, TestRandom& random) {
    return x < 16 ? noisy(random, 0.4f, 0.3f) : Sample{0.4f, 1};
  });
  AdaptiveSettings s;
  s.threshold = 1e-4f;
  s.max_samples = 200;
  RoundPlanner planner(s, 32, 32, 5);
  frame.render(planner);
  for (int y = 0; y < 32; ++y) {
    for (int x = 0; x < 32; ++x) {
      if (x >= 14 && x < 18) continue;  // the kernel reaches across the edge
      const size_t i = size_t(y) * 32 + size_t(x);
      ASSERT_EQ(planner.stop_of(i), x < 16 ? PixelStop::kMaximum : PixelStop::kThreshold);
      if (x < 16) {
        ASSERT_EQ(frame.count(x, y), 200u);
      } else {
        ASSERT_LT(frame.count(x, y), 100u);
      }
    }
  }
}

TEST(RoundPlanner, NoPixelIsFinishedBelowItsLeast) {
  SyntheticFrame frame(16, 16, 11, [](int, int, TestRandom&) { return Sample{0.4f, 1}; });
  AdaptiveSettings s;
  s.threshold = 0.1f;
  s.min_samples = 48;
  RoundPlanner planner(s, 16, 16, 5);
  frame.render(planner);
  for (const uint32_t n : frame.counts()) ASSERT_EQ(n, 48u);
}

// The number of samples is proportional to 1 / sqrt(cost). The camera ray costs .17, and every
// further ray costs 1 (pixel_statistics.cpp).
TEST(RoundPlanner, DearSamplesAreFewer) {
  const double ratio = sample_ratio_by_cost(budget_settings(400));
  // The ratio is lower, because a pixel keeps the samples that it got when its deviation was
  // overestimated. If samples were proportional to 1 / cost, the ratio would be 7.
  const double expected = std::sqrt(8.17 / 1.17);
  EXPECT_GT(ratio, 0.85 * expected);
  EXPECT_LT(ratio, 1.02 * expected);
}

TEST(RoundPlanner, TheSamplesFollowTheDeviation) {
  const double ratio = sample_ratio_by_noise(budget_settings(400));
  EXPECT_GT(ratio, 0.8 * 4);  // lower for the reason given above
  EXPECT_LT(ratio, 1.02 * 4);
}

// The gain is the reduction of a known variance v, from v / n to v / m.
TEST(RoundPlanner, GainsAreTheVarianceThatGoes) {
  SyntheticFrame frame = even_noise(48, 48, 3);
  RoundPlanner planner(budget_settings(400), 48, 48, 5);
  std::vector<uint32_t> have(48 * 48, 100), targets(48 * 48, 400);
  targets[7] = 100;
  std::vector<float> gains;
  planner.expected_gains(have, targets, &gains);
  EXPECT_EQ(gains, std::vector<float>(48 * 48, 0.0f)) << "nothing has been seen yet";
  frame.render(planner);
  planner.expected_gains(have, targets, &gains);
  EXPECT_EQ(gains[7], 0.0f);
  double mean = 0;
  for (const float gain : gains) mean += double(gain) / double(gains.size());
  // The three channels have a deviation of 0.1, weighted by the metric. The mean is over 2304
  // estimates of it.
  const double variance = square(double(planner.errors().deviation[8]));
  EXPECT_NEAR(gains[8], variance / 100 - variance / 400, 1e-6 * variance);
  EXPECT_NEAR(mean, 0.01 * (1.0 / 100 - 1.0 / 400), 0.1 * 0.01 * (1.0 / 100 - 1.0 / 400));
}

TEST(RoundPlanner, UnbiasedSamplesEveryPixel) {
  SyntheticFrame frame(64, 64, 14, [](int x, int y, TestRandom& random) {
    return x == 5 && y == 5 ? noisy(random, 2.0f, 1.0f) : Sample{0.1f, 2};
  });
  AdaptiveSettings s = budget_settings(32);
  s.unbiased = true;
  RoundPlanner planner(s, 64, 64, 5);
  frame.render(planner, [&] {
    for (size_t i = 0; i < frame.counts().size(); ++i) {
      ASSERT_GT(planner.targets()[i], frame.counts()[i]) << "pixel " << i;
    }
  });
}

// The result depends neither on the number of threads nor on an earlier run in the process.
TEST(RoundPlanner, TheSameForAnyThreads) {
  for (const EstimatorEntry& entry : estimator_table()) {
    for (const float threshold : {0.0f, 0.01f}) {
      std::vector<std::vector<uint32_t>> reference;
      constexpr int kThreads[] = {1, 7, 2, 2};
      for (const int threads : std::span(kThreads).first(test::long_or_short(4u, 2u))) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                        size_t(threads));
        tbb::task_arena arena(threads);
        arena.execute([&] {
          SyntheticFrame frame(150, 101, 15, [](int x, int, TestRandom& random) {
            return noisy(random, 0.4f, 0.002f * float(x));
          });
          AdaptiveSettings s;
          s.estimator = entry.name;
          s.budget = 40;
          s.threshold = threshold;
          RoundPlanner planner(s, 150, 101, 5);
          std::vector<std::vector<uint32_t>> rounds;
          const auto update = [&] {
            rounds.emplace_back(planner.targets().begin(), planner.targets().end());
          };
          update();
          frame.render(planner, update);
          if (reference.empty()) reference = rounds;
          EXPECT_GT(rounds.size(), 1u);
          EXPECT_EQ(rounds, reference) << entry.name << ", " << threads << " threads";
        });
      }
    }
  }
}

// Non-finite samples count as black, and samples whose squares overflow count as large. The frame
// continues, and the estimate of its error is finite for estimators that have one.
TEST(RoundPlanner, NonFiniteSamplesStopNothing) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  for (const EstimatorEntry& entry : estimator_table()) {
    for (const float bad : {nan, infinity, -infinity, 3e38f, -3e38f}) {
      for (const double part : {1.0, 0.1}) {
        SCOPED_TRACE(std::string(entry.name) + ", " + std::to_string(bad));
        SyntheticFrame frame(32, 32, 16, [&](int x, int y, TestRandom& random) {
          const bool hit = x == 12 && y == 7 && random.next_double() < part;
          return hit ? Sample{bad, 2} : noisy(random, 0.4f, 0.1f);
        });
        AdaptiveSettings s = budget_settings(48, ErrorMetric::kDisplay);
        s.estimator = entry.name;
        RoundPlanner planner(s, 32, 32, 5);
        frame.render(planner);
        EXPECT_LE(frame.mean_count(), 48.8);  // 1024 counts are rounded to 16
        EXPECT_GT(frame.mean_count(), 47.0);
        EXPECT_EQ(std::isfinite(planner.error_estimate()), entry.rms_error);
        for (const float error : planner.errors().error) ASSERT_TRUE(error >= 0.0f);
      }
    }
  }
}

// With a historical estimator, the half of the pixels with the larger errors gets a batch.
TEST(RoundPlanner, BatchesGoToTheLargerErrors) {
  for (const EstimatorEntry& entry : estimator_table()) {
    if (entry.batch == 0) continue;
    SCOPED_TRACE(entry.name);
    SyntheticFrame frame(32, 32, 17, [](int x, int, TestRandom& random) {
      return noisy(random, 0.4f, 0.01f * float(x));
    });
    AdaptiveSettings s = budget_settings(100);
    s.estimator = entry.name;
    RoundPlanner planner(s, 32, 32, 5);
    frame.render(planner, [&] {
      std::vector<float> chosen, others;
      for (size_t i = 0; i < frame.counts().size(); ++i) {
        const uint32_t more = planner.targets()[i] - frame.counts()[i];
        ASSERT_TRUE(more == 0 || more == entry.batch);
        (more > 0 ? chosen : others).push_back(planner.errors().error[i]);
      }
      EXPECT_LE(chosen.size(), 512u);
      EXPECT_GE(*std::ranges::min_element(chosen), *std::ranges::max_element(others));
    });
    EXPECT_NEAR(frame.mean_count(), 100.0, 0.2);
    EXPECT_LE(frame.mean_count(), 100.0);
  }
}

TEST(RoundPlanner, RecordsThePlansForAPixel) {
  SyntheticFrame frame = even_noise(16, 16, 18);
  RoundPlanner planner(budget_settings(64), 16, 16, 5);
  planner.record(37);
  std::vector<uint32_t> targets;
  frame.render(planner, [&] { targets.push_back(planner.targets()[37]); });
  ASSERT_GE(planner.records().size(), targets.size());
  uint32_t have = 8;
  for (size_t r = 0; r < targets.size(); ++r) {
    const RoundRecord& record = planner.records()[r];
    EXPECT_EQ(record.round, int(r) + 1);
    EXPECT_EQ(record.samples, have);
    EXPECT_EQ(record.target, targets[r]);
    EXPECT_GT(record.error, 0.0f);
    EXPECT_NEAR(record.deviation, 0.1f, 0.05f);
    EXPECT_NEAR(record.cost, 1.17f, 1e-6f);
    have = targets[r];
  }
}

}  // namespace
}  // namespace emberline
