#include "renderer/drivers/adaptive/frame_error.h"

#include <algorithm>
#include <cmath>

#include "renderer/drivers/adaptive/error_metric.h"
#include "renderer/drivers/adaptive/ordered_sum.h"

namespace emberline {
namespace {

double squared_error_of_part(const PixelStatistics& p, const float* effective_samples,
                             size_t channel, size_t begin, size_t end) {
  const float *count = p.count.data(), *second = p.second_count.data(),
              *mean = p.mean[channel].data(), *variance = p.variance[channel].data(),
              *difference = p.stream_difference[channel].data();
  float lanes[kSumLanes] = {};
  for_lanes(begin, end, [&](size_t i, size_t lane) {
    const float of_mean = sample_variance(count[i], second[i], difference[i], variance[i]) /
                          std::max(1.0f, effective_samples[i]);
    lanes[lane] += display_error_weight(mean[i], std::sqrt(of_mean), kLeastReportedSlope) * of_mean;
  });
  return sum_of_lanes(lanes);
}

}  // namespace

double frame_error(const PixelStatistics& pixels, std::span<const float> effective_samples) {
  const float* counts = effective_samples.empty() ? pixels.count.data() : effective_samples.data();
  const double sum = ordered_sum(pixels.size(), [&](size_t begin, size_t end) {
    double of_part = 0.0;
    for (size_t c = 0; c < 3; ++c) of_part += squared_error_of_part(pixels, counts, c, begin, end);
    return of_part;
  });
  return std::sqrt(sum / std::max(1.0, 3 * double(pixels.size())));
}

}  // namespace emberline
