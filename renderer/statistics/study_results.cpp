#include "renderer/statistics/study_results.h"

namespace emberline {
namespace {

constexpr StudyMetricEntry kMetrics[] = {
    {"mse", "mean squared error of radiance", StudyMetric::kMse, &StudyError::mse, true},
    {"relmse", "squared error over squared radiance", StudyMetric::kRelMse, &StudyError::rel_mse,
     true},
    {"relmse_trimmed", "relmse without the worst 0.1 % of pixels", StudyMetric::kRelMseTrimmed,
     &StudyError::rel_mse_trimmed, true},
    {"display_mse", "mean squared error of display values", StudyMetric::kDisplay,
     &StudyError::display_mse, true},
    {"flip", "mean FLIP, the difference that an observer sees", StudyMetric::kFlip,
     &StudyError::flip, false},
    {"p95_absolute", "95th percentile of the pixels' errors of radiance", StudyMetric::kP95Absolute,
     &StudyError::p95_absolute, false},
    {"p95_display", "95th percentile of the pixels' errors of display values",
     StudyMetric::kP95Display, &StudyError::p95_display, false},
};

}  // namespace

std::span<const StudyMetricEntry> study_metric_table() { return kMetrics; }

const StudyMetricEntry& study_metric_entry(StudyMetric metric) { return kMetrics[size_t(metric)]; }

}  // namespace emberline
