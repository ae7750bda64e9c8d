// Error estimates of the whole crop. They are only reported; no stopping rule uses them.
#pragma once

#include <algorithm>

#include "renderer/drivers/adaptive/pixel_statistics.h"
#include "renderer/drivers/adaptive/round_averages.h"

namespace emberline {

// Returns the sample variance of a pixel, defined such that dividing it by the pixel's sample count
// gives the variance of the pixel's mean. If there are two streams or halves, it is computed from
// the difference of their means. Otherwise it is `spread`, the variance of the samples as if they
// were independent. The result is limited, so that sums over a frame stay finite.
inline float sample_variance(float count, float second_count, float difference, float spread) {
  constexpr float kMaxVariance = 1e18f;
  const float n = std::max(1.0f, count), b = second_count, a = n - b;
  const float streams = difference * difference * (a * b / n);
  return std::min(a > 0.0f && b > 0.0f ? streams : spread, kMaxVariance);
}

// Returns the expected RMS error of the displayed crop (sRGB, [0, 1]) over pixels and channels.
// Each pixel's squared error is estimated from the difference of the pixel's own two streams, and
// weighted for display (display_error_weight()) at the pixel's own mean. A single difference is
// unreliable, but the mean of thousands of squared differences is reliable. So this estimate needs
// no pooling over neighbours, which decisions about single pixels need. Pooling would weight noise
// beside a highlight by the steep display curve of the shadow next to it, and would treat pixels
// next to a lamp as clipped. Without a second stream, samples are treated as independent. Includes
// `missed`, the result of missed_light_error(). The result is finite, and the same for any number
// of threads.
double frame_error(const PixelStatistics& pixels, double missed = 0.0);
// Returns the same estimate for a picture that shows averages over rounds. Uses
// RoundAverages::variance().
double frame_error(const RoundAverages& averages, size_t pixels, double missed = 0.0);

}  // namespace emberline
