#include "renderer/drivers/adaptive/frame_error.h"

#include <algorithm>
#include <cmath>

#include "renderer/drivers/adaptive/error_estimator.h"
#include "renderer/drivers/adaptive/ordered_sum.h"

namespace emberline {
namespace {

// Sums over pixels and channels of one part of the crop.
struct ErrorSums {
  double error = 0.0;        // squared display error
  double independent = 0.0;  // the same if samples were independent
  double one_sample = 0.0;   // the same for pixels with one sample: n times `error`

  ErrorSums& operator+=(const ErrorSums& other) {
    error += other.error;
    independent += other.independent;
    one_sample += other.one_sample;
    return *this;
  }
};

ErrorSums sums_of_channel(const PixelStatistics& p, size_t c, size_t begin, size_t end) {
  const float *count = p.count.data(), *second = p.second_count.data(), *mean = p.mean[c].data(),
              *spread = p.variance[c].data(), *difference = p.stream_difference[c].data();
  float error[kSumLanes] = {}, independent[kSumLanes] = {}, one_sample[kSumLanes] = {};
  for_lanes(begin, end, [&](size_t i, size_t lane) {
    const float n = std::max(1.0f, count[i]);
    const float variance = sample_variance(count[i], second[i], difference[i], spread[i]);
    const float weight = display_error_weight(mean[i], std::sqrt(variance / n), 0.0f);
    error[lane] += weight * (variance / n);
    independent[lane] += weight * (std::min(spread[i], kMaxVariance) / n);
    one_sample[lane] += weight * variance;
  });
  return {sum_of_lanes(error), sum_of_lanes(independent), sum_of_lanes(one_sample)};
}

// Returns the squared error from sums whose `error` is the gain of the last doubling.
double error_after_doubling(const ErrorSums& sums) {
  if (!(sums.error > 0.0)) return 0.0;
  constexpr double kMaxExponent = 3.0;  // that of a smooth function of one dimension
  const double samples = std::max(2.0, sums.one_sample / sums.error);
  const double excess = std::log(sums.independent / sums.error) / std::log(samples);
  const double exponent = std::clamp(1.0 + excess, 1.0, kMaxExponent);
  return sums.error / (std::exp2(exponent) - 1.0);
}

double rms_of(double sum, size_t pixels) {
  return std::sqrt(sum / std::max(1.0, 3 * double(pixels)));
}

}  // namespace

double frame_error(const PixelStatistics& pixels, Compared compared, double missed) {
  const ErrorSums sums = ordered_sum(pixels.size(), [&](size_t begin, size_t end) {
    ErrorSums partial_sums;
    for (size_t c = 0; c < 3; ++c) partial_sums += sums_of_channel(pixels, c, begin, end);
    return partial_sums;
  });
  const double error = compared == Compared::kHalves ? error_after_doubling(sums) : sums.error;
  return rms_of(error + missed, pixels.size());
}

double frame_error(const RoundAverages& averages, size_t pixels, double missed) {
  const double sum = ordered_sum(pixels, [&](size_t begin, size_t end) {
    double partial_sum = 0.0;
    for (size_t c = 0; c < 3; ++c) {
      float lanes[kSumLanes] = {};
      for_lanes(begin, end, [&](size_t i, size_t lane) {
        const auto mean = float(averages.mean(i, c)), variance = float(averages.variance(i, c));
        lanes[lane] += display_error_weight(mean, std::sqrt(variance), 0.0f) * variance;
      });
      partial_sum += sum_of_lanes(lanes);
    }
    return partial_sum;
  });
  return rms_of(sum + missed, pixels);
}

}  // namespace emberline
