#include "renderer/drivers/adaptive/frame_error.h"

#include <algorithm>
#include <cmath>

#include "renderer/drivers/adaptive/error_estimator.h"
#include "renderer/drivers/adaptive/ordered_sum.h"

namespace emberline {
namespace {

template <typename MeanOf, typename VarianceOf>
double squared_error_of_part(size_t begin, size_t end, const MeanOf& mean_of,
                             const VarianceOf& variance_of) {
  float lanes[kSumLanes] = {};
  for_lanes(begin, end, [&](size_t i, size_t lane) {
    const float variance = variance_of(i);
    lanes[lane] += display_error_weight(mean_of(i), std::sqrt(variance), 0.0f) * variance;
  });
  return sum_of_lanes(lanes);
}

double rms_of(double sum, size_t pixels) {
  return std::sqrt(sum / std::max(1.0, 3 * double(pixels)));
}

}  // namespace

double frame_error(const PixelStatistics& pixels, double missed) {
  const double sum = ordered_sum(pixels.size(), [&](size_t begin, size_t end) {
    double partial_sum = 0.0;
    for (size_t c = 0; c < 3; ++c) {
      const float *count = pixels.count.data(), *second = pixels.second_count.data(),
                  *mean = pixels.mean[c].data(), *variance = pixels.variance[c].data(),
                  *difference = pixels.stream_difference[c].data();
      partial_sum += squared_error_of_part(
          begin, end, [=](size_t i) { return mean[i]; },
          [=](size_t i) {
            return sample_variance(count[i], second[i], difference[i], variance[i]) /
                   std::max(1.0f, count[i]);
          });
    }
    return partial_sum;
  });
  return rms_of(sum + missed, pixels.size());
}

double frame_error(const RoundAverages& averages, size_t pixels, double missed) {
  const double sum = ordered_sum(pixels, [&](size_t begin, size_t end) {
    double partial_sum = 0.0;
    for (size_t c = 0; c < 3; ++c) {
      partial_sum += squared_error_of_part(
          begin, end, [&](size_t i) { return float(averages.mean(i, c)); },
          [&](size_t i) { return float(averages.variance(i, c)); });
    }
    return partial_sum;
  });
  return rms_of(sum + missed, pixels);
}

}  // namespace emberline
