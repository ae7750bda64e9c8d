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

// Fills the map with finish(i, e) for each pixel and no deviations, in parallel; e is the standard
// error of the pixel's mean in display units (display_error.h), root of the mean over the channels,
// and variance_of_mean(c, i) channel c's, in linear radiance squared. That is asked of every pixel,
// those without samples too, in a loop that vectorises if it has no branch.
template <typename VarianceOfMean, typename Finish>
void fill_display_errors(const PixelStatistics& pixels, const VarianceOfMean& variance_of_mean,
                         const Finish& finish, ErrorMap* out) {
  constexpr size_t kGrain = 4096;
  out->deviation.clear();
  out->error.resize(pixels.size());
  parallel_ranges(pixels.size(), kGrain, [&](size_t begin, size_t end) {
    float* __restrict error = out->error.data();
    std::fill(error + begin, error + end, 0.0f);
    for (size_t c = 0; c < 3; ++c) {
      const float* mean = pixels.mean[c].data();
      for (size_t i = begin; i < end; ++i) {
        const float variance = variance_of_mean(c, i);
        error[i] += display_error_weight(mean[i], std::sqrt(variance)) * variance;
      }
    }
    for (size_t i = begin; i < end; ++i) {
      error[i] = map_error(finish(i, std::sqrt(error[i] * (1.0f / 3))));
    }
  });
}

// The same from the pixels' sample variances; for finish() to judge those with n < 2.
template <typename Finish>
void fill_display_errors_of_samples(const PixelStatistics& pixels, const Finish& finish,
                                    ErrorMap* out) {
  const auto variance_of_mean = [&](size_t c, size_t i) {
    return pixels.variance[c][i] / pixels.count[i];
  };
  fill_display_errors(pixels, variance_of_mean, finish, out);
}

}  // namespace emberline
