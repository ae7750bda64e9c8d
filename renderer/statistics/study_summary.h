// Statistics of a study's runs: means over seeds with 95 % confidence intervals, slopes, speedups
// at equal error, error ratios at equal time, calibration and overhead. All functions are pure
// functions of StudyResults.
//
// Errors and times are positive and vary by factors, so means are geometric, with Student-t
// intervals of the mean logarithm. A mean squared error that is 0 or negative is excluded from
// these means. (It can be negative because the reference's noise is removed.) `runs` is the number
// of remaining values. A single value has no interval.
//
// Comparisons are paired by seed: a ratio is computed for each seed whose runs both methods have
// finished, and then averaged over the seeds.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "renderer/statistics/study_results.h"

namespace emberline {

struct Estimate {
  double value = 0;
  std::optional<double> low, high;  // 95 % confidence interval; needs two values
  size_t runs = 0;                  // number of values
};

// Returns the 0.975 quantile of Student's t distribution with `degrees` (>= 1) degrees of freedom,
// to within 1e-9, by bisection of the distribution function, which is a finite sum.
double student_t_975(int degrees);

// Both functions return nothing if there are no values. The geometric mean uses only the positive
// ones.
std::optional<Estimate> mean_estimate(std::span<const double> values);
std::optional<Estimate> geometric_mean_estimate(std::span<const double> values);
// Applies an increasing function fn(x) to the value and both ends of the interval.
Estimate map_estimate(Estimate estimate, const auto& fn) {
  estimate.value = fn(estimate.value);
  if (estimate.low) estimate.low = fn(*estimate.low);
  if (estimate.high) estimate.high = fn(*estimate.high);
  return estimate;
}

// The horizontal axis of error curves.
enum class StudyAxis : uint8_t { kSamples, kWall, kCpu };
// The position of a checkpoint or a CurvePoint on the axis, in samples per pixel or seconds.
double position(const auto& point, StudyAxis axis) {
  return axis == StudyAxis::kSamples ? point.mean_samples
         : axis == StudyAxis::kWall  ? point.wall_s
                                     : point.cpu_s;
}

// Index of the baseline in results.methods; empty if no method has the baseline's name.
std::optional<size_t> baseline_method(const StudyResults& results);
// Returns the finished run of this method with this seed, or null.
const StudyRun* find_run(const StudyResults& results, size_t method, uint32_t seed);
// The number of a method's failed runs, and the reason of the first one.
struct FailureCount {
  size_t runs = 0;
  std::string reason;
};
FailureCount failures(const StudyResults& results, size_t method);

// One method's results at one budget, averaged over its seeds.
struct CurvePoint {
  double budget = 0;
  double mean_samples = 0, wall_s = 0, cpu_s = 0;  // geometric means
  Estimate error;                                  // in the metric
};
// Returns one point for each budget that at least one run has reached.
std::vector<CurvePoint> study_curve(const StudyResults& results, size_t method, StudyMetric metric);

// Arithmetic mean of the signed bias at a budget. Here and below, `budget` is an index into
// settings.budgets.
std::optional<Estimate> signed_bias(const StudyResults& results, size_t method, size_t budget);

// Convergence order: fits a least-squares line to log error against log position in each run, and
// returns the mean of the slopes. With independent samples, the slope of a squared metric is -1.
// Runs with checkpoints at fewer than two positions are left out.
std::optional<Estimate> error_slope(const StudyResults& results, size_t method, StudyMetric metric,
                                    StudyAxis axis);

// How many times as long the baseline takes to reach the error that the method has at this budget.
// The baseline's run with the same seed is interpolated between its checkpoints, linearly in log
// error against log position. Beyond the checkpoints, the first or last segment is extended;
// `extrapolated` is the number of runs that needed this.
struct Speedup {
  Estimate ratio;
  size_t extrapolated = 0;
};
std::optional<Speedup> equal_error_speedup(const StudyResults& results, size_t method,
                                           StudyMetric metric, StudyAxis axis, size_t budget);

// The method's error at the budget divided by the baseline's error at the same position, which is
// interpolated in the same way.
std::optional<Estimate> equal_position_error_ratio(const StudyResults& results, size_t method,
                                                   StudyMetric metric, StudyAxis axis,
                                                   size_t budget);

// The ratio of estimated to true RMS error, averaged over a group of calibration points from all
// runs of a method. A group contains the points whose mean samples are within a factor of sqrt(2)
// of the same power of two.
struct CalibrationGroup {
  double mean_samples = 0;  // geometric mean
  Estimate ratio;
};
std::vector<CalibrationGroup> calibration(const StudyResults& results, size_t method);

// The speedup in processor time divided by the metric's Neyman limit: the fraction of the
// possible gain that the method achieves. The baseline must sample uniformly. Returns nothing for
// metrics other than mse, relmse and display, and for denoised methods.
std::optional<Estimate> neyman_fraction(const StudyResults& results, size_t method,
                                        StudyMetric metric, size_t budget);

// Time and effect of denoising a method's pictures at a budget; empty for a method without
// denoising.
struct FilterSummary {
  double cpu_s = 0;                        // geometric mean
  double unchanged_fraction = 0;           // arithmetic mean
  std::optional<Estimate> estimate_ratio;  // error that the filter expects / true error
};
std::optional<FilterSummary> filter_summary(const StudyResults& results, size_t method,
                                            size_t budget);

// The method's processor time per sample at the budget, divided by the baseline's. This shows the
// cost of the driver itself and of the pixels that it chooses.
std::optional<Estimate> overhead(const StudyResults& results, size_t method, size_t budget);

}  // namespace emberline
