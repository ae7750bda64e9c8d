// What the estimators that judge each pixel by its own samples share.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "renderer/core/parallel.h"
#include "renderer/drivers/adaptive/error_estimator.h"

namespace emberline {

// The error of a pixel of which too little is known: above every threshold, yet finite.
inline constexpr float kUnknownError = 1e6f;

// An error as a map may hold it; NaN, from statistics that are not finite, says nothing.
inline float map_error(float error) {
  return error <= kUnknownError ? std::max(error, 0.0f) : kUnknownError;
}

// Standard error of the pixel's mean in display units (error_metric.h), root of the mean over the
// channels; variance_of_mean(c) is channel c's, in linear radiance squared.
template <typename VarianceOfMean>
float display_error(const PixelStatistics& pixels, size_t i,
                    const VarianceOfMean& variance_of_mean) {
  float sum = 0.0f;
  for (size_t c = 0; c < 3; ++c) {
    const float variance = variance_of_mean(c);
    const float weight =
        error_weight(ErrorMetric::kDisplay, 0.0f, pixels.mean[c][i], std::sqrt(variance));
    sum += weight * variance;
  }
  return std::sqrt(sum / 3.0f);
}

// The same from the pixel's sample variance; for n >= 2.
inline float display_error_of_samples(const PixelStatistics& pixels, size_t i) {
  const float per_sample = 1.0f / pixels.count[i];
  return display_error(pixels, i, [&](size_t c) { return pixels.variance[c][i] * per_sample; });
}

// Fills the map with pixel_error(i) for each pixel and no deviations, in parallel.
template <typename PixelError>
void fill_errors(const PixelStatistics& pixels, const PixelError& pixel_error, ErrorMap* out) {
  constexpr size_t kGrain = 4096;
  out->deviation.clear();
  out->error.resize(pixels.size());
  parallel_ranges(pixels.size(), kGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) out->error[i] = map_error(pixel_error(i));
  });
}

}  // namespace emberline
