// Code shared by the estimators that judge each pixel by its own samples.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "renderer/core/parallel.h"
#include "renderer/drivers/adaptive/error_estimator.h"

namespace emberline {

// The error of a pixel whose error cannot be estimated yet. It is above every threshold, but
// finite.
inline constexpr float kUnknownError = 1e6f;

// Clamps an error to [0, kUnknownError]. NaN, which comes from non-finite statistics, becomes
// kUnknownError.
inline float map_error(float error) {
  return error <= kUnknownError ? std::max(error, 0.0f) : kUnknownError;
}

// Sets the error of each pixel i to pixel_error(i), in parallel, and clears the deviations.
template <typename PixelError>
void fill_errors(const PixelStatistics& pixels, const PixelError& pixel_error, ErrorMap* out) {
  constexpr size_t kGrain = 4096;
  out->deviation.clear();
  out->error.resize(pixels.size());
  parallel_ranges(pixels.size(), kGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) out->error[i] = map_error(pixel_error(i));
  });
}

// Sets the error of each pixel i to finish(i, e), in parallel, and clears the deviations. Here e is
// the standard deviation of the pixel's mean in display units (display_error.h), as the root mean
// square over the channels. variance_of_mean(c, i) must return the variance of pixel i's mean in
// channel c, in squared linear radiance. It is called for every pixel, even one without samples.
// The loop vectorises if variance_of_mean() has no branch.
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

// Like fill_display_errors(), with variances computed from the pixels' samples. finish() must
// handle pixels with fewer than 2 samples.
template <typename Finish>
void fill_display_errors_of_samples(const PixelStatistics& pixels, const Finish& finish,
                                    ErrorMap* out) {
  const auto variance_of_mean = [&](size_t c, size_t i) {
    return pixels.variance[c][i] / pixels.count[i];
  };
  fill_display_errors(pixels, variance_of_mean, finish, out);
}

}  // namespace emberline
