// Distributes the samples of a whole frame at once, for plans and forecasts. Rounds, which
// distribute only the next samples, are in round_planner.h.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "renderer/drivers/adaptive/adaptive_settings.h"
#include "renderer/drivers/adaptive/error_estimator.h"
#include "renderer/drivers/work_forecast.h"

namespace emberline {

// The largest number of samples that a pixel may get.
inline float sample_limit(const AdaptiveSettings& s) {
  return s.max_samples > 0 ? float(s.max_samples) : float(kMaxSamples);
}

// Factor on the estimated number of samples that a pixel needs to reach the threshold.
inline constexpr float kThresholdMargin = 1.05f;

// The pilot has this many samples per pixel, depending on the budget.
inline constexpr uint32_t kMinPilot = 8, kMaxPilot = 16;
inline constexpr double kUnlimited = 1e18;

// Increases rates at random by up to a sixteenth, so that pixels with equal rates, as in a black
// frame, do not all double at once. Noise makes rates differ by more than this.
float jitter_rate(float rate, uint32_t seed, size_t i);

// What is known about the pixels of a frame. `seed` decides the order of pixels with equal rates
// (jitter_rate()).
struct FrameEstimates {
  const PixelStatistics& pixels;
  const ErrorMap& errors;  // of all pixels, with deviations
  uint32_t seed;
};

// Returns the sample counts for a new frame that has these limits, starts without samples and does
// not change the counts later. A count is at most 16 times the count on which its estimate is
// based, or the least count that every pixel gets if that is more.
std::vector<uint32_t> allocate_frame(const FrameEstimates& known, const AdaptiveSettings& limits);

// Returns the work of a frame that has these limits and now has `current` samples.
WorkForecast predict_work(const FrameEstimates& known, const AdaptiveSettings& limits,
                          std::span<const uint32_t> current);

}  // namespace emberline
