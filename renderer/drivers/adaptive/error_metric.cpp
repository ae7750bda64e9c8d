#include "renderer/drivers/adaptive/error_metric.h"

namespace emberline {
namespace {

constexpr NamedValue<ErrorMetric> kMetrics[] = {
    {"display", "squared error of the picture as it is looked at (sRGB)", ErrorMetric::kDisplay},
    {"mse", "squared error of linear radiance", ErrorMetric::kMse},
    {"relmse", "squared error over squared radiance", ErrorMetric::kRelMse},
    {"denoised", "as display, of the denoised picture: with `denoise`, which comes with it",
     ErrorMetric::kDenoised},
};

}  // namespace

std::span<const NamedValue<ErrorMetric>> error_metric_table() { return kMetrics; }

}  // namespace emberline
