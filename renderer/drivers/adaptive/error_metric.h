// In what units an error counts. Each metric weighs a channel's squared error by a function of the
// channel's value; expected errors are sums of weight x variance.
#pragma once

#include <span>
#include <string_view>

#include "renderer/core/display_error.h"

namespace emberline {

enum class ErrorMetric { kMse, kRelMse, kDisplay };

struct ErrorMetricEntry {
  std::string_view name;
  std::string_view summary;
  ErrorMetric metric;
};
inline constexpr std::string_view kDefaultAllocation = "display";

// The table behind --allocation, its --help and its error message.
std::span<const ErrorMetricEntry> error_metric_table();
ErrorMetric parse_error_metric(std::string_view name);  // throws UsageError

// The factor on a squared error of a channel whose value is `mean`, known to +- `deviation` (its
// standard error): 1 for mse; 1 / (mean^2 + epsilon) for relmse, epsilon as `compare` has it, a
// hundredth of the squared mean of the whole picture; display_error_weight() for display.
inline float error_weight(ErrorMetric metric, float epsilon, float mean, float deviation) {
  if (metric == ErrorMetric::kMse) return 1.0f;
  if (metric == ErrorMetric::kRelMse) return 1.0f / (mean * mean + epsilon);
  return display_error_weight(mean, deviation);
}

}  // namespace emberline
