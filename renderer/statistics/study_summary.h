// Computes statistics of a study's runs: means over seeds with 95 % confidence intervals, slopes,
// speedups at equal error, error ratios at equal time, calibration and overhead. All functions are
// pure.
//
// Errors and times are positive and vary by factors, so means are geometric, and their intervals
// are Student-t intervals of the mean logarithm. These means exclude mean squared errors that are 0
// or negative. (Such an error can be negative because the reference's noise is removed.) `runs` is
// the number of remaining values. A single value has no interval.
//
// Comparisons are paired by seed: for each seed whose runs both methods have finished, a ratio is
// computed. Then the ratios are averaged over the seeds.
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
// to within 1e-9. Uses bisection of the distribution function, which is a finite sum.
double student_t_975(int degrees);

// These two functions return nothing if there are no values. The geometric mean uses only the
// positive values.
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
// Returns the position of a checkpoint or a CurvePoint on the axis, in samples per pixel or in
// seconds.
double position(const auto& point, StudyAxis axis) {
  return axis == StudyAxis::kSamples ? point.mean_samples
         : axis == StudyAxis::kWall  ? point.wall_s
                                     : point.cpu_s;
}

// Returns the index of the baseline in results.methods; nothing if no method has the baseline's
// name.
std::optional<size_t> baseline_method(const StudyResults& results);
// Returns the finished run of this method with this seed, or null.
const StudyRun* find_run(const StudyResults& results, size_t method, uint32_t seed);
// The number of a method's failed runs, and the reason why the first of them failed.
struct FailureCount {
  size_t runs = 0;
  std::string reason;
};
FailureCount failures(const StudyResults& results, size_t method);

// One method's results at one budget, averaged over its seeds.
struct CurvePoint {
  double budget = 0;
  double mean_samples = 0, wall_s = 0, cpu_s = 0;  // geometric means
  Estimate error;                                  // error in the metric
};
// Returns one point for each budget that at least one run has reached.
std::vector<CurvePoint> study_curve(const StudyResults& results, size_t method, StudyMetric metric);

// Returns the arithmetic mean of the signed bias at a budget. Here and below, `budget` is an index
// into settings.budgets.
std::optional<Estimate> signed_bias(const StudyResults& results, size_t method, size_t budget);

// Measures the convergence order. Fits a least-squares line to log error against log position in
// each run, and returns the mean of the slopes. With independent samples, the slope of a squared
// metric is -1. Runs with checkpoints at fewer than two positions are left out.
std::optional<Estimate> error_slope(const StudyResults& results, size_t method, StudyMetric metric,
                                    StudyAxis axis);

// The speedup over the baseline at equal error. At this budget, the method has some position on the
// axis and some error. `ratio` is the position at which the baseline reaches this error, divided by
// the position of the method. The baseline's run with the same seed is interpolated between its
// checkpoints, linearly in log error against log position. Beyond the checkpoints, the first or
// last segment is extended; `extrapolated` is the number of runs for which this was necessary.
struct Speedup {
  Estimate ratio;
  size_t extrapolated = 0;
};
std::optional<Speedup> equal_error_speedup(const StudyResults& results, size_t method,
                                           StudyMetric metric, StudyAxis axis, size_t budget);

// Returns the method's error at the budget, divided by the baseline's error at the same position on
// the axis. The baseline's error is interpolated as for equal_error_speedup().
std::optional<Estimate> equal_position_error_ratio(const StudyResults& results, size_t method,
                                                   StudyMetric metric, StudyAxis axis,
                                                   size_t budget);

// The ratio of the estimated to the true RMS error, averaged over a group of calibration points
// from all runs of a method. A group contains the points whose `mean_samples` are within a factor
// of sqrt(2) of the same power of two.
struct CalibrationGroup {
  double mean_samples = 0;  // geometric mean
  Estimate ratio;
};
std::vector<CalibrationGroup> calibration(const StudyResults& results, size_t method);

// Returns the speedup in processor time divided by the metric's Neyman limit. This is the fraction
// of the possible gain that the method achieves. The baseline must sample uniformly. Returns
// nothing for metrics other than mse, relmse and display, and for denoised methods.
std::optional<Estimate> neyman_fraction(const StudyResults& results, size_t method,
                                        StudyMetric metric, size_t budget);

// The time and the effect of denoising a method's pictures at a budget.
struct FilterSummary {
  double cpu_s = 0;                        // geometric mean
  double unchanged_fraction = 0;           // arithmetic mean
  std::optional<Estimate> estimate_ratio;  // filter's expected error / true error
};
std::optional<FilterSummary> filter_summary(const StudyResults& results, size_t method,
                                            size_t budget);

// Returns the method's processor time per sample at the budget, divided by the baseline's. This
// ratio shows the cost of the driver itself and of the pixels that the driver chooses.
std::optional<Estimate> overhead(const StudyResults& results, size_t method, size_t budget);

}  // namespace emberline
