// Synthetic frames shared by the tests of all planners, and figures of their plans.
#pragma once

#include <cmath>

#include "unit/synthetic_frame.h"
#include "unit/synthetic_pixels.h"

namespace emberline::test {

// Uniform noise of +-1.7 deviations about a mean, so that the spread of a pixel is soon known.
inline SyntheticFrame::Sample noisy(TestRandom& random, float mean, float deviation,
                                    uint32_t rays = 2) {
  return {mean + deviation * 3.4641016f * (random.next() - 0.5f), rays};
}

inline SyntheticFrame even_noise(int width, int height, uint64_t seed) {
  return {width, height, seed,
          [](int, int, TestRandom& random) { return noisy(random, 0.4f, 0.1f); }};
}

// Settings with two streams, where counts need no steps; step_planner_test.cpp tests `nested`.
inline AdaptiveSettings budget_settings(uint32_t budget,
                                        ErrorMetric allocation = ErrorMetric::kMse) {
  AdaptiveSettings s;
  s.estimator = "two-stream";
  s.budget = budget;
  s.allocation = allocation;
  return s;
}

// Mean samples of a noise-free pixel in a frame of which one half is noisy.
inline double noiseless_samples(const AdaptiveSettings& settings) {
  SyntheticFrame frame(64, 64, 6, [](int x, int, TestRandom& random) {
    return x < 32 ? noisy(random, 0.5f, 0.2f) : SyntheticFrame::Sample{0.5f, 2};
  });
  RoundPlanner planner(settings, 64, 64, 5);
  frame.render(planner);
  double quiet = 0;
  // Beyond the reach of the noisy half's kernel.
  for (int y = 0; y < 64; ++y) {
    for (int x = 36; x < 64; ++x) quiet += frame.count(x, y) / (64.0 * 28);
  }
  return quiet;
}

// Ratio of the samples of two halves, one with four times the other's deviation.
inline double sample_ratio_by_noise(const AdaptiveSettings& settings) {
  SyntheticFrame frame(96, 48, 13, [](int x, int, TestRandom& random) {
    return noisy(random, 0.4f, x < 48 ? 0.03f : 0.12f);
  });
  RoundPlanner planner(settings, 96, 48, 5);
  frame.render(planner);
  double quiet = 0, loud = 0;
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 44; ++x) {
      quiet += frame.count(x, y);
      loud += frame.count(95 - x, y);
    }
  }
  return loud / quiet;
}

// Ratio of the samples of two halves, one with a cost of 1.17 per sample and the other with 8.17.
inline double sample_ratio_by_cost(const AdaptiveSettings& settings) {
  SyntheticFrame frame(96, 48, 12, [](int x, int, TestRandom& random) {
    return noisy(random, 0.4f, 0.1f, x < 48 ? 2 : 9);
  });
  RoundPlanner planner(settings, 96, 48, 5);
  frame.render(planner);
  double cheap = 0, dear = 0;
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 96; ++x) (x < 48 ? cheap : dear) += frame.count(x, y);
  }
  return cheap / dear;
}

// Samples of a uniformly noisy frame, relative to those that bring its error to the threshold.
inline double spent_to_needed_ratio(const AdaptiveSettings& settings) {
  SyntheticFrame frame = even_noise(64, 64, 9);
  RoundPlanner planner(settings, 64, 64, 5);
  frame.render(planner);
  // display_value's slope at .4, times .1 per sample.
  const double slope = double(display_value(0.401f) - display_value(0.399f)) / 0.002;
  return frame.mean_count() / std::pow(slope * 0.1 / double(settings.threshold), 2);
}

}  // namespace emberline::test
