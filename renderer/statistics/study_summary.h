// Figures from the runs of a study: means over seeds with 95 % confidence intervals, slopes,
// speedups at equal error, ratios at equal time, calibration, overhead. Pure functions of
// StudyResults.
//
// Errors and times are positive and vary by factors, so their means are taken of logarithms:
// geometric means, and Student-t intervals of the mean logarithm. A mean of squares that the
// reference's noise has brought to 0 or below is left out; `runs` says how many values remain. From
// one value there is no interval.
//
// Comparisons are paired by seed: of each seed that both methods have finished, the ratio; then the
// mean over seeds.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "renderer/statistics/study_results.h"

namespace emberline {

struct Estimate {
  double value = 0;
  std::optional<double> low, high;  // the 95 % confidence interval, from two values on
  size_t runs = 0;                  // how many values it is from
};

// The quantile 0.975 of Student's t distribution. `degrees` at least 1. By bisection on the
// distribution function, which is a finite sum: right to 1e-9.
double student_t_975(int degrees);

// Nothing of an empty list. The geometric mean is of the positive values alone.
std::optional<Estimate> mean_estimate(std::span<const double> values);
std::optional<Estimate> geometric_mean_estimate(std::span<const double> values);
// Applies fn(x), which rises with x, to value and interval.
Estimate mapped(Estimate estimate, const auto& fn) {
  estimate.value = fn(estimate.value);
  if (estimate.low) estimate.low = fn(*estimate.low);
  if (estimate.high) estimate.high = fn(*estimate.high);
  return estimate;
}

// The axis that errors are drawn against.
enum class StudyAxis : uint8_t { kSamples, kWall, kCpu };
// Of a checkpoint or a point of a curve: samples per pixel, or seconds.
double position(const auto& point, StudyAxis axis) {
  return axis == StudyAxis::kSamples ? point.mean_samples
         : axis == StudyAxis::kWall  ? point.wall_s
                                     : point.cpu_s;
}

// The index of the baseline in results.methods; nothing if no method has its name.
std::optional<size_t> baseline_method(const StudyResults& results);
// The finished run of a method with a seed, or null.
const StudyRun* find_run(const StudyResults& results, size_t method, uint32_t seed);
// How many runs of a method have failed, and the first one's reason.
struct FailureCount {
  size_t runs = 0;
  std::string reason;
};
FailureCount failures(const StudyResults& results, size_t method);

// A method at one budget, over its seeds.
struct CurvePoint {
  double budget = 0;
  double mean_samples = 0, wall_s = 0, cpu_s = 0;  // geometric means
  Estimate error;                                  // in the metric
};
// By budget; budgets that no run has reached are not there.
std::vector<CurvePoint> study_curve(const StudyResults& results, size_t method, StudyMetric metric);

// Signed bias at a budget (by index into settings.budgets): arithmetic mean.
std::optional<Estimate> signed_bias(const StudyResults& results, size_t method, size_t budget);

// The order by which the error falls: the slope of the least-squares line through log error against
// log position, of each run, then the mean over runs. -1 is Monte Carlo's for squared metrics.
// Needs runs with two checkpoints of different positions.
std::optional<Estimate> error_slope(const StudyResults& results, size_t method, StudyMetric metric,
                                    StudyAxis axis);

// How many times as long the baseline takes (along its own run of the same seed, straight lines in
// log error against log position between its checkpoints) for the error that the method has at the
// budget. Beyond the baseline's checkpoints its first or last line goes on; `extrapolated` says for
// how many of the runs that was needed.
struct Speedup {
  Estimate ratio;
  size_t extrapolated = 0;
};
std::optional<Speedup> equal_error_speedup(const StudyResults& results, size_t method,
                                           StudyMetric metric, StudyAxis axis, size_t budget);

// The method's error over the baseline's at the position that the method has at the budget, the
// baseline's by the same lines.
std::optional<Estimate> equal_position_error_ratio(const StudyResults& results, size_t method,
                                                   StudyMetric metric, StudyAxis axis,
                                                   size_t budget);

// Estimated over true RMS error, by rounds: points of all the method's runs whose mean samples are
// within a factor of sqrt(2) of a power of two are one group.
struct CalibrationGroup {
  double mean_samples = 0;  // geometric mean
  Estimate ratio;
};
std::vector<CalibrationGroup> calibration(const StudyResults& results, size_t method);

// The speedup in processor time over the Neyman limit of that metric, which the baseline must be
// uniform for: how much of what there is to gain was gained. Only for mse, relmse and display, and
// not of denoised pictures.
std::optional<Estimate> neyman_fraction(const StudyResults& results, size_t method,
                                        StudyMetric metric, size_t budget);

// Time and effect of denoising a method's pictures at a budget; nothing for a raw method.
struct FilterSummary {
  double cpu_s = 0;                        // geometric mean
  double kept_share = 0;                   // arithmetic mean
  std::optional<Estimate> estimate_ratio;  // the error that the filter expects over the true one
};
std::optional<FilterSummary> filter_summary(const StudyResults& results, size_t method,
                                            size_t budget);

// Processor time a sample over the baseline's, at the budget: what the driver itself costs, and
// what its choice of pixels does.
std::optional<Estimate> overhead(const StudyResults& results, size_t method, size_t budget);

}  // namespace emberline
