// In what units an error counts. Each metric weighs a channel's squared error by a function of the
// channel's value; expected errors are sums of weight x variance.
#pragma once

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
// From a table: within 1e-4.
float display_value(float linear);

// The factor on a squared error of a channel whose value is `mean`, known to +- `deviation` (its
// standard error): 1 for mse; 1 / (mean^2 + epsilon) for relmse, epsilon as `compare` has it, a
// hundredth of the squared mean of the whole picture; for display the squared slope of
// display_value() over mean +- deviation, so that clipped white and noise about to leave it are
// told apart, and at least kLeastDisplaySlope^2, so that no pixel counts for nothing.
float error_weight(ErrorMetric metric, float epsilon, float mean, float deviation);
inline constexpr float kLeastDisplaySlope = 0.02f;

}  // namespace emberline
