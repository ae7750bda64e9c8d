// Settings of the adaptive driver, without the code that uses them.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/drivers/driver_choices.h"

namespace emberline {

inline constexpr ErrorMetric kDefaultAllocation = ErrorMetric::kDisplay;

// A channel whose error decides about samples (judged_channels.h).
struct JudgedChannel {
  std::string name;        // "RGB", "A", "light.*" or the name of an AOV
  float threshold = 0.0f;  // in the channel's own scale; 0: the frame's threshold
  bool operator==(const JudgedChannel&) const = default;
};

// A pixel or the frame ends at the first limit that is reached. A limit of 0 means that there is
// none.
struct AdaptiveSettings {
  std::string_view estimator = kDefaultEstimator;
  ErrorMetric allocation = kDefaultAllocation;
  float threshold = 0.0f;    // limit for ErrorMap::error
  uint32_t budget = 0;       // average samples per pixel of the crop
  uint32_t min_samples = 0;  // samples before a pixel may finish; 0: the estimator's choice
  uint32_t max_samples = 0;  // limit for each pixel
  bool two_halves = false;   // if true, every pixel needs samples in both halves of the film
  bool unbiased = false;     // if true, every round samples every pixel; requires a budget and an
                             // estimator that distributes samples by deviation
  bool is_open = false;      // if true, the budget is that of the pilot, until it is extended
  std::vector<JudgedChannel> judged = {};  // empty: R G B; requires an estimator with halves
};

}  // namespace emberline
