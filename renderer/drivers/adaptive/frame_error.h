// How large the error of the whole crop is, for the report: what no stopping rule goes by.
#pragma once

#include <algorithm>

#include "renderer/drivers/adaptive/pixel_statistics.h"
#include "renderer/drivers/adaptive/round_averages.h"

namespace emberline {

// Of a sample of a pixel, such that over the pixel's count it is that of its mean: from the
// difference of two streams' means, or of two halves', where there are two; else from the samples'
// `spread`, as if they were independent. So limited that sums over a frame stay finite.
inline float sample_variance(float count, float second_count, float difference, float spread) {
  constexpr float kMost = 1e18f;
  const float n = std::max(1.0f, count), b = second_count, a = n - b;
  const float streams = difference * difference * (a * b / n);
  return std::min(a > 0.0f && b > 0.0f ? streams : spread, kMost);
}

// Expected RMS error of the crop as it is displayed (sRGB, [0, 1]), over pixels and channels:
// from each pixel's own two streams, at its own mean. One pixel's difference says little, but the
// mean of thousands of squares is sure; pooled over neighbours first, as a decision about a pixel
// needs it, noise beside a highlight would be weighed by the steep curve of the shadow next to it,
// and what is next to a lamp as clipped. Where there is no second stream, as if samples were
// independent. `missed` is ErrorMap's, added. Finite. The same for any threads.
double frame_error(const PixelStatistics& pixels, double missed = 0.0);
// The same of averages of rounds, which know their own variances.
double frame_error(const RoundAverages& averages, size_t pixels, double missed = 0.0);

}  // namespace emberline
