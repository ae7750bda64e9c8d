#include "renderer/drivers/adaptive/frame_error.h"

#include <algorithm>
#include <cmath>

#include "renderer/drivers/adaptive/error_metric.h"
#include "renderer/drivers/adaptive/ordered_sum.h"

namespace emberline {
namespace {

double squared_error_of_part(const PixelStatistics& p, size_t channel, size_t begin, size_t end) {
  const float *count = p.count.data(), *second = p.second_count.data(),
              *mean = p.mean[channel].data(), *variance = p.variance[channel].data(),
              *difference = p.stream_difference[channel].data();
  constexpr float kMost = 1e18f;  // so that sums stay finite
  float lanes[kSumLanes] = {};
  for_lanes(begin, end, [&](size_t i, size_t lane) {
    const float n = std::max(1.0f, count[i]), b = second[i], a = n - b;
    const float streams = difference[i] * difference[i] * (a * b / n);
    const float of_mean = std::min(a > 0.0f && b > 0.0f ? streams : variance[i], kMost) / n;
    lanes[lane] += display_error_weight(mean[i], std::sqrt(of_mean), kLeastReportedSlope) * of_mean;
  });
  return sum_of_lanes(lanes);
}

}  // namespace

double frame_error(const PixelStatistics& pixels) {
  const double sum = ordered_sum(pixels.size(), [&](size_t begin, size_t end) {
    double of_part = 0.0;
    for (size_t c = 0; c < 3; ++c) of_part += squared_error_of_part(pixels, c, begin, end);
    return of_part;
  });
  return std::sqrt(sum / std::max(1.0, 3 * double(pixels.size())));
}

}  // namespace emberline
