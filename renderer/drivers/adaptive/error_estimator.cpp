#include "renderer/drivers/adaptive/error_estimator.h"

#include "renderer/core/names.h"
#include "renderer/drivers/adaptive/chi_square_estimator.h"
#include "renderer/drivers/adaptive/contrast_estimator.h"
#include "renderer/drivers/adaptive/dammertz_estimator.h"
#include "renderer/drivers/adaptive/kajiya_estimator.h"
#include "renderer/drivers/adaptive/painter_sloan_estimator.h"
#include "renderer/drivers/adaptive/two_stream_estimator.h"

namespace emberline {
namespace {

constexpr NamedValue<ErrorMetric> kMetrics[] = {
    {"display", "squared error of the displayed picture (sRGB)", ErrorMetric::kDisplay},
    {"mse", "squared error of linear radiance", ErrorMetric::kMse},
    {"relmse", "squared error divided by squared radiance", ErrorMetric::kRelMse},
};

// The first row is the default.
constexpr EstimatorEntry kEstimators[] = {
    {.name = "nested",
     .summary = "variance estimated from how the pixel changed when its samples last doubled, "
                "pooled over neighbours; sample counts are powers of two or 1.5 times a power of "
                "two, which stratify well",
     .estimate = estimate_two_stream,
     .first_samples = 16,
     .rms_error = true,
     .halves = true},
    {.name = "two-stream",
     .summary = "variance from two independent sample streams, pooled over neighbours; samples go "
                "where they reduce the error most for their cost",
     .estimate = estimate_two_stream,
     .streams = StreamCount::kTwo,
     .first_samples = 16,
     .rms_error = true},
    {.name = "contrast",
     .summary = "contrast between neighbouring pixels (Mitchell 1987)",
     .estimate = estimate_contrast,
     .first_samples = kContrastBatch,
     .batch = kContrastBatch},
    {.name = "painter-sloan",
     .summary = "confidence interval of the pixel's mean (Painter & Sloan 1989)",
     .estimate = estimate_painter_sloan,
     .first_samples = kPainterSloanBatch,
     .batch = kPainterSloanBatch,
     .whole_tree = true},
    {.name = "chi-square",
     .summary = "upper bound on the variance of the pixel's mean (Lee et al. 1985)",
     .estimate = estimate_chi_square,
     .first_samples = kChiSquareBatch,
     .batch = kChiSquareBatch},
    {.name = "kajiya",
     .summary = "difference of the pixel's two halves (Kajiya 1986)",
     .estimate = estimate_kajiya,
     .streams = StreamCount::kTwo,
     .first_samples = kKajiyaBatch,
     .batch = kKajiyaBatch,
     .rms_error = true},
    {.name = "dammertz",
     .summary = "difference of two half images over blocks (Dammertz et al. 2009)",
     .estimate = estimate_dammertz,
     .streams = StreamCount::kTwo,
     .first_samples = kDammertzBatch,
     .batch = kDammertzBatch},
};

}  // namespace

std::span<const NamedValue<ErrorMetric>> error_metric_table() { return kMetrics; }

std::span<const EstimatorEntry> estimator_table() { return kEstimators; }

const EstimatorEntry& find_estimator(std::string_view name) {
  return find_named(kEstimators, "`estimator`", "estimator", name);
}

}  // namespace emberline
