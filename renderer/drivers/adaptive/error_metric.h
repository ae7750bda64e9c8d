// In what units an error counts. Each metric weighs a channel's squared error by a function of the
// channel's value; expected errors are sums of weight x variance.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <string_view>

namespace emberline {

enum class ErrorMetric { kMse, kRelMse, kDisplay };

struct ErrorMetricEntry {
  std::string_view name;
  std::string_view summary;
  ErrorMetric metric;
};
// The table behind --allocation, its --help and its error message.
std::span<const ErrorMetricEntry> error_metric_table();
ErrorMetric parse_error_metric(std::string_view name);  // throws UsageError

// The sRGB transfer function (IEC 61966-2-1), linear light to [0, 1], clipped there; NaN gives 0.
// Within 1e-6, without a branch, so that loops over pixels vectorise.
inline float display_value(float linear) {
  constexpr float kStraight = 0.0031308f;  // below, the curve is a line
  const float x = linear > 0.0f ? std::min(linear, 1.0f) : 0.0f;
  // The curve over t = 1 - x^(1/4), which bends little: 1 + t q(t), exact at white. q interpolates
  // in the Chebyshev nodes of [0, 1 - kStraight^(1/4)]; its degree makes the error 3e-7.
  const float t = 1.0f - std::sqrt(std::sqrt(x));
  float q = 0.0528659709f;
  q = q * t - 0.0934508964f;
  q = q * t + 0.0832892284f;
  q = q * t - 0.0214407835f;
  q = q * t + 0.0283523463f;
  q = q * t + 0.064457804f;
  q = q * t + 0.586135924f;
  q = q * t - 1.75833344f;
  return x < kStraight ? 12.92f * x : 1.0f + t * q;
}

inline constexpr float kLeastDisplaySlope = 0.02f;

// The squared slope of display_value() over mean +- deviation, so that clipped white and noise
// about to leave it are told apart; at least least_slope^2, so that no pixel counts for
// nothing. A deviation below .001 is taken for that: the slope is a difference of two floats.
inline float display_error_weight(float mean, float deviation,
                                  float least_slope = kLeastDisplaySlope) {
  const float d = std::max(deviation, 1e-3f);
  const float slope = (display_value(mean + d) - display_value(mean - d)) / (2 * d);
  return std::max(slope * slope, least_slope * least_slope);
}

// The factor on a squared error of a channel whose value is `mean`, known to +- `deviation` (its
// standard error): 1 for mse; 1 / (mean^2 + epsilon) for relmse, epsilon as `compare` has it, a
// hundredth of the squared mean of the whole picture; display_error_weight() for display.
inline float error_weight(ErrorMetric metric, float epsilon, float mean, float deviation) {
  if (metric == ErrorMetric::kMse) return 1.0f;
  if (metric == ErrorMetric::kRelMse) return 1.0f / (mean * mean + epsilon);
  return display_error_weight(mean, deviation);
}

}  // namespace emberline
