// Settings of the adaptive driver.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/drivers/driver_choices.h"

namespace emberline {

inline constexpr ErrorMetric kDefaultAllocation = ErrorMetric::kDisplay;

// A channel whose error helps to decide how many samples a pixel gets (judged_channels.h).
struct JudgedChannel {
  std::string name;        // "RGB", "A", "light.*" or the name of an AOV
  float threshold = 0.0f;  // in the channel's own scale; 0: the frame's threshold
  bool operator==(const JudgedChannel&) const = default;
};

// A pixel, or the whole frame, ends at the first limit that it reaches. A limit of 0 means no
// limit.
struct AdaptiveSettings {
  std::string_view estimator = kDefaultEstimator;
  ErrorMetric allocation = kDefaultAllocation;
  float threshold = 0.0f;    // limit for ErrorMap::error
  uint32_t budget = 0;       // average samples per pixel of the crop
  uint32_t min_samples = 0;  // samples before a pixel may finish; 0: the estimator's choice
  uint32_t max_samples = 0;  // limit for each pixel
  bool two_halves = false;   // if true, every pixel needs samples in both halves of the film
  // If true, every round samples every pixel, and the picture shows unbiased means
  // (round_averages.h). Requires a budget and an estimator that fills ErrorMap::deviation.
  bool unbiased = false;
  // If true, the frame has a time budget: `budget` is only enough for the pilot, until
  // FrameDriver::extend_work() raises it.
  bool is_open = false;
  // Empty: R G B. Any other list requires an estimator with halves (EstimatorEntry).
  std::vector<JudgedChannel> judged = {};
};

}  // namespace emberline
