// The settings of the adaptive driver. Does not include its planner.
#pragma once

#include <cstdint>
#include <string_view>

#include "renderer/drivers/driver_choices.h"

namespace emberline {

inline constexpr ErrorMetric kDefaultAllocation = ErrorMetric::kDisplay;

// Whichever limit is met first ends a pixel or the frame. 0: no such limit.
struct AdaptiveSettings {
  std::string_view estimator = kDefaultEstimator;
  ErrorMetric allocation = kDefaultAllocation;
  float threshold = 0.0f;    // of ErrorMap::error
  uint32_t budget = 0;       // samples of a pixel, on average over the crop
  uint32_t min_samples = 0;  // before a pixel may be finished; 0: the estimator's choice
  uint32_t max_samples = 0;  // of any pixel
  bool two_halves = false;   // every pixel is to have samples in both halves of the film
  bool unbiased = false;     // every pixel takes part in every round; with a budget alone, and
                             // with an estimator that shares by deviation
};

}  // namespace emberline
