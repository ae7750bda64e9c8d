// Statistics of a study's runs: means over seeds with 95 % confidence intervals, slopes, speedups
// at equal error, ratios at equal time, calibration, overhead. Pure functions of StudyResults.
//
// Errors and times are positive and vary by factors, so means are geometric, with Student-t
// intervals of the mean logarithm. A mean of squares is excluded if it is 0 or negative, which is
// possible because the reference's noise is subtracted; `runs` is the number of remaining values. A
// single value has no interval.
//
// Comparisons are paired by seed: a ratio is computed for each seed that both methods have
// finished, then the mean over seeds.
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

// The 0.975 quantile of Student's t distribution, exact to 1e-9. `degrees` must be at least 1.
// Bisects the distribution function, which is a finite sum.
double student_t_975(int degrees);

// These return nothing for an empty list. The geometric mean uses only the positive values.
std::optional<Estimate> mean_estimate(std::span<const double> values);
std::optional<Estimate> geometric_mean_estimate(std::span<const double> values);
// Applies an increasing function fn(x) to value and interval.
Estimate map_estimate(Estimate estimate, const auto& fn) {
  estimate.value = fn(estimate.value);
  if (estimate.low) estimate.low = fn(*estimate.low);
  if (estimate.high) estimate.high = fn(*estimate.high);
  return estimate;
}

// The horizontal axis of error curves.
enum class StudyAxis : uint8_t { kSamples, kWall, kCpu };
// Position of a checkpoint or of a point of a curve on the axis, in samples per pixel or in
// seconds.
double position(const auto& point, StudyAxis axis) {
  return axis == StudyAxis::kSamples ? point.mean_samples
         : axis == StudyAxis::kWall  ? point.wall_s
                                     : point.cpu_s;
}

// Index of the baseline in results.methods; empty if no method has the baseline's name.
std::optional<size_t> baseline_method(const StudyResults& results);
// The finished run of a method with a seed, or null.
const StudyRun* find_run(const StudyResults& results, size_t method, uint32_t seed);
// The number of a method's failed runs, and the reason of the first one.
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
// Returns one point for each budget that at least one run has reached.
std::vector<CurvePoint> study_curve(const StudyResults& results, size_t method, StudyMetric metric);

// Arithmetic mean of the signed bias at a budget (index into settings.budgets).
std::optional<Estimate> signed_bias(const StudyResults& results, size_t method, size_t budget);

// Convergence order: the slope of the least-squares line through log error against log position of
// each run, then the mean over runs. It is -1 for Monte Carlo and squared metrics. Only runs with
// checkpoints at two or more positions count.
std::optional<Estimate> error_slope(const StudyResults& results, size_t method, StudyMetric metric,
                                    StudyAxis axis);

// How many times as long as the method at this budget the baseline takes for the same error. The
// baseline's curve is its run with the same seed, linear in log error against log position between
// checkpoints. Beyond the checkpoints, the first or last segment is extended; `extrapolated` is the
// number of runs where that was needed.
struct Speedup {
  Estimate ratio;
  size_t extrapolated = 0;
};
std::optional<Speedup> equal_error_speedup(const StudyResults& results, size_t method,
                                           StudyMetric metric, StudyAxis axis, size_t budget);

// The method's error at the budget divided by the baseline's error at the same position,
// interpolated in the same way.
std::optional<Estimate> equal_position_error_ratio(const StudyResults& results, size_t method,
                                                   StudyMetric metric, StudyAxis axis,
                                                   size_t budget);

// Ratio of estimated to true RMS error, for a group of points from all runs of a method. The mean
// samples of a group are within a factor of sqrt(2) of a power of two.
struct CalibrationGroup {
  double mean_samples = 0;  // geometric mean
  Estimate ratio;
};
std::vector<CalibrationGroup> calibration(const StudyResults& results, size_t method);

// The speedup in processor time divided by the metric's Neyman limit: the fraction of the possible
// gain. The baseline must be uniform. Only for mse, relmse and display, and not for denoised
// pictures.
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

// Processor time per sample at the budget, divided by that of the baseline. It shows the cost of
// the driver and of its choice of pixels.
std::optional<Estimate> overhead(const StudyResults& results, size_t method, size_t budget);

}  // namespace emberline
