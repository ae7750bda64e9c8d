#include "renderer/drivers/adaptive/kajiya_estimator.h"

#include "renderer/drivers/adaptive/pixel_errors.h"

namespace emberline {

float half_difference_variance(float difference, float first, float second) {
  const float n = first + second;
  return difference * difference * (first / n) * (second / n);
}

void estimate_kajiya(const PixelStatistics& pixels, const EstimatorSettings&, ErrorMap* out) {
  const auto variance_of_mean = [&](size_t c, size_t i) {
    const float second = pixels.second_count[i], first = pixels.count[i] - second;
    return half_difference_variance(pixels.stream_difference[c][i], first, second);
  };
  const auto if_known = [&](size_t i, float error) {
    const float second = pixels.second_count[i], first = pixels.count[i] - second;
    return first >= 1.0f && second >= 1.0f ? error : kUnknownError;
  };
  fill_display_errors(pixels, variance_of_mean, if_known, out);
}

}  // namespace emberline
