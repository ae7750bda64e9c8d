#include "renderer/drivers/adaptive/error_metric.h"

#include "renderer/core/names.h"

namespace emberline {
namespace {

constexpr ErrorMetricEntry kMetrics[] = {
    {"display", "squared error of the picture as it is looked at (sRGB)", ErrorMetric::kDisplay},
    {"mse", "squared error of linear radiance", ErrorMetric::kMse},
    {"relmse", "squared error over squared radiance", ErrorMetric::kRelMse},
};

}  // namespace

std::span<const ErrorMetricEntry> error_metric_table() { return kMetrics; }

ErrorMetric parse_error_metric(std::string_view name) {
  return find_named(kMetrics, "--allocation", "metric", name).metric;
}

}  // namespace emberline
