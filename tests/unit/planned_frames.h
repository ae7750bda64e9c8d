// Synthetic frames that the tests of all planners share, and figures that describe their plans.
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

// Settings for the estimator `two-stream`, which allows any sample count. The estimator `nested`
// allows only powers of two and 1.5 times these; step_planner_test.cpp tests it.
inline AdaptiveSettings budget_settings(uint32_t budget,
                                        ErrorMetric allocation = ErrorMetric::kMse) {
  AdaptiveSettings s;
  s.estimator = "two-stream";
  s.budget = budget;
  s.allocation = allocation;
  return s;
}

// The mean number of samples of a noise-free pixel in a frame whose other half is noisy.
inline double noiseless_samples(const AdaptiveSettings& settings) {
  SyntheticFrame frame(64, 64, 6, [](int x, int, TestRandom& random) {
    return x < 32 ? noisy(random, 0.5f, 0.2f) : SyntheticFrame::Sample{0.5f, 2};
  });
  RoundPlanner planner(settings, 64, 64, 5);
  frame.render(planner);
  double quiet = 0;
  // These pixels are beyond the reach of the noisy half's kernel.
  for (int y = 0; y < 64; ++y) {
    for (int x = 36; x < 64; ++x) quiet += frame.count(x, y) / (64.0 * 28);
  }
  return quiet;
}

// The ratio of the samples in two halves of a frame. One half has four times the deviation of the
// other.
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

// The ratio of the samples in two halves of a frame. A sample costs 1.17 in one half and 8.17 in
// the other.
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

// The samples of a uniformly noisy frame, relative to the number that brings its error to the
// threshold.
inline double spent_to_needed_ratio(const AdaptiveSettings& settings) {
  SyntheticFrame frame = even_noise(64, 64, 9);
  RoundPlanner planner(settings, 64, 64, 5);
  frame.render(planner);
  // The slope of display_value at .4. The noise is .1 per sample.
  const double slope = double(display_value(0.401f) - display_value(0.399f)) / 0.002;
  return frame.mean_count() / std::pow(slope * 0.1 / double(settings.threshold), 2);
}

}  // namespace emberline::test
