#include "renderer/drivers/adaptive/kajiya_estimator.h"

#include "renderer/drivers/adaptive/pixel_errors.h"

namespace emberline {

float half_difference_variance(float difference, float first, float second) {
  const float n = first + second;
  return difference * difference * (first / n) * (second / n);
}

void KajiyaEstimator::estimate(const PixelStatistics& pixels, ErrorMetric, ErrorMap* out) const {
  const auto pixel_error = [&](size_t i) {
    const float second = pixels.second_count[i], first = pixels.count[i] - second;
    if (!(first >= 1.0f && second >= 1.0f)) return kUnknownError;
    return display_error(pixels, i, [&](size_t c) {
      return half_difference_variance(pixels.stream_difference[c][i], first, second);
    });
  };
  fill_errors(pixels, pixel_error, out);
}

}  // namespace emberline
