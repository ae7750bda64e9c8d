#include "renderer/statistics/study_summary.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>

#include "renderer/statistics/value_list.h"

namespace emberline {
namespace {

constexpr StudyMetricEntry kMetrics[] = {
    {"mse", "mean squared error of radiance", StudyMetric::kMse, &StudyError::mse, true},
    {"relmse", "squared error divided by squared radiance", StudyMetric::kRelMse,
     &StudyError::rel_mse, true},
    {"relmse_trimmed", "relmse without the worst 0.1 % of pixels", StudyMetric::kRelMseTrimmed,
     &StudyError::rel_mse_trimmed, true},
    {"display_mse", "mean squared error of display values", StudyMetric::kDisplay,
     &StudyError::display_mse, true},
    {"flip", "mean FLIP, the difference that an observer notices", StudyMetric::kFlip,
     &StudyError::flip, false},
    {"p95_absolute", "95th percentile of the pixels' radiance errors", StudyMetric::kP95Absolute,
     &StudyError::p95_absolute, false},
    {"p95_display", "95th percentile of the pixels' display errors", StudyMetric::kP95Display,
     &StudyError::p95_display, false},
};

// Returns the probability that |t| is below sqrt(degrees) tan(angle). Uses the finite sums of
// Abramowitz & Stegun 1964, equations 26.7.3 (odd) and 26.7.4 (even).
double student_t_central(int degrees, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  const bool odd = degrees % 2 == 1;
  double term = odd ? c : 1.0, sum = 0;
  for (int k = odd ? 1 : 0; k <= degrees - 2; k += 2) {
    sum += term;
    term *= c * c * (k + 1) / (k + 2);
  }
  return odd ? 2 / std::numbers::pi * (angle + s * sum) : s * sum;
}

struct LogPoint {
  double position, error;
};
using LogCurve = std::vector<LogPoint>;

// Converts a run to a curve of log error against log position, by ascending position. Drops points
// whose position or error is not positive and finite. If several checkpoints have the same
// position, keeps the last one.
LogCurve log_curve(const StudyRun& run, const StudyMetricEntry& metric, StudyAxis axis) {
  LogCurve curve;
  for (const StudyCheckpoint& checkpoint : run.checkpoints) {
    const double at = position(checkpoint, axis), error = checkpoint.error.*metric.value;
    if (!(at > 0 && error > 0 && std::isfinite(at) && std::isfinite(error))) continue;
    const LogPoint point = {std::log(at), std::log(error)};
    if (!curve.empty() && point.position <= curve.back().position) {
      curve.back() = point;
    } else {
      curve.push_back(point);
    }
  }
  return curve;
}

struct Crossing {
  double value = 0;  // a logarithm
  bool extrapolated = false;
};

// Returns the coordinate `to` of the point at which the coordinate `from` of the curve first
// reaches `at`. Interpolates within a segment, or extends the first or last one. Returns nothing if
// `from` does not rise (`direction` 1) or fall (`direction` -1) along this segment. A curve with
// only one point is extended as a line with the slope d(to) / d(from) = `slope`.
std::optional<Crossing> interpolate(const LogCurve& curve, double LogPoint::*from,
                                    double LogPoint::*to, double direction, double slope,
                                    double at) {
  if (curve.empty()) return std::nullopt;
  if (curve.size() == 1) {
    const double difference = at - curve[0].*from;
    return Crossing{curve[0].*to + difference * slope, std::abs(difference) > 0};
  }
  const auto beyond = [&](double x, double y) { return direction * x > direction * y; };
  size_t k = 0;
  while (k + 2 < curve.size() && beyond(at, curve[k + 1].*from)) ++k;
  const LogPoint &a = curve[k], &b = curve[k + 1];
  if (!beyond(b.*from, a.*from)) return std::nullopt;
  return Crossing{a.*to + (b.*to - a.*to) * (at - a.*from) / (b.*from - a.*from),
                  beyond(a.*from, at) || beyond(at, b.*from)};
}

// Returns the slope of log error over log position with independent samples. It is used for a curve
// with only one point.
double expected_slope(const StudyMetricEntry& metric) { return metric.squared ? -1.0 : -0.5; }

// Returns the position at which the curve first reaches the error.
std::optional<Crossing> position_at(const LogCurve& curve, double error,
                                    const StudyMetricEntry& metric) {
  return interpolate(curve, &LogPoint::error, &LogPoint::position, -1.0,
                     1.0 / expected_slope(metric), error);
}

std::optional<Crossing> error_at(const LogCurve& curve, double at, const StudyMetricEntry& metric) {
  return interpolate(curve, &LogPoint::position, &LogPoint::error, 1.0, expected_slope(metric), at);
}

const StudyCheckpoint* checkpoint_at(const StudyRun& run, double budget) {
  const auto found = std::ranges::find(run.checkpoints, budget, &StudyCheckpoint::budget);
  return found == run.checkpoints.end() ? nullptr : &*found;
}

using VisitCheckpoint = std::function<void(const StudyCheckpoint&, const StudyRun&)>;

// Calls visit(checkpoint, run) for every finished run of the method that has reached the budget.
void for_each_checkpoint(const StudyResults& results, size_t method, double budget,
                         const VisitCheckpoint& visit) {
  for (const StudyRun& run : results.runs) {
    if (run.method != method || run.status != StudyRunStatus::kDone) continue;
    if (const StudyCheckpoint* checkpoint = checkpoint_at(run, budget)) visit(*checkpoint, run);
  }
}

// Like for_each_checkpoint(), but passes the baseline's run with the same seed to `visit`, and
// skips seeds that the baseline has not finished.
void for_each_pair(const StudyResults& results, size_t method, size_t budget,
                   const VisitCheckpoint& visit) {
  const std::optional<size_t> baseline = baseline_method(results);
  if (!baseline || budget >= results.settings.budgets.size()) return;
  for_each_checkpoint(results, method, results.settings.budgets[budget],
                      [&](const StudyCheckpoint& checkpoint, const StudyRun& run) {
                        const StudyRun* other = find_run(results, *baseline, run.seed);
                        if (other) visit(checkpoint, *other);
                      });
}

// Returns the mean of the values and its Student-t interval, with `to_result` applied to the mean
// and to both ends of the interval.
std::optional<Estimate> student_interval(std::span<const double> values,
                                         double (*to_result)(double)) {
  if (values.empty()) return std::nullopt;
  const auto n = double(values.size());
  double mean = 0, squares = 0;
  for (const double v : values) mean += v / n;
  for (const double v : values) squares += (v - mean) * (v - mean);
  Estimate estimate;
  estimate.value = to_result(mean);
  estimate.runs = values.size();
  if (values.size() > 1) {
    const double half = student_t_975(int(values.size()) - 1) * std::sqrt(squares / (n - 1) / n);
    estimate.low = to_result(mean - half);
    estimate.high = to_result(mean + half);
  }
  return estimate;
}

std::optional<Estimate> geometric_estimate(std::span<const double> logarithms) {
  return student_interval(logarithms, [](double x) { return std::exp(x); });
}

// Computes a ratio between a method's checkpoint and the baseline's curve for each seed, and
// returns the geometric mean. `ratio` receives logarithms and returns the logarithm of the ratio.
std::optional<Speedup> mean_ratio(
    const StudyResults& results, size_t method, const StudyMetricEntry& metric, StudyAxis axis,
    size_t budget,
    const std::function<std::optional<Crossing>(const LogPoint&, const LogCurve& baseline)>&
        ratio) {
  std::vector<double> logarithms;
  size_t extrapolated = 0;
  for_each_pair(results, method, budget,
                [&](const StudyCheckpoint& checkpoint, const StudyRun& baseline) {
                  const double error = checkpoint.error.*metric.value;
                  const double at = position(checkpoint, axis);
                  if (!(error > 0 && at > 0)) return;
                  const std::optional<Crossing> value =
                      ratio({std::log(at), std::log(error)}, log_curve(baseline, metric, axis));
                  if (!value) return;
                  logarithms.push_back(value->value);
                  extrapolated += value->extrapolated;
                });
  const std::optional<Estimate> mean = geometric_estimate(logarithms);
  return mean ? std::optional(Speedup{*mean, extrapolated}) : std::nullopt;
}

double geometric_mean(std::span<const double> values) {
  const std::optional<Estimate> mean = geometric_mean_estimate(values);
  return mean ? mean->value : 0.0;
}

}  // namespace

std::span<const StudyMetricEntry> study_metric_table() { return kMetrics; }

const StudyMetricEntry& study_metric_entry(StudyMetric metric) { return kMetrics[size_t(metric)]; }

double student_t_975(int degrees) {
  assert(degrees >= 1);
  double low = 0, high = std::numbers::pi / 2;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    (student_t_central(degrees, middle) < 0.95 ? low : high) = middle;
  }
  return std::sqrt(double(degrees)) * std::tan(low);
}

std::optional<Estimate> mean_estimate(std::span<const double> values) {
  return student_interval(values, [](double x) { return x; });
}

std::optional<Estimate> geometric_mean_estimate(std::span<const double> values) {
  std::vector<double> logarithms;
  for (const double v : values) {
    if (v > 0 && std::isfinite(v)) logarithms.push_back(std::log(v));
  }
  return geometric_estimate(logarithms);
}

std::optional<size_t> baseline_method(const StudyResults& results) {
  const auto found =
      std::ranges::find(results.methods, results.settings.baseline, &StudyMethod::name);
  if (found == results.methods.end()) return std::nullopt;
  return size_t(found - results.methods.begin());
}

const StudyRun* find_run(const StudyResults& results, size_t method, uint32_t seed) {
  const auto found = std::ranges::find_if(results.runs, [&](const StudyRun& run) {
    return run.method == method && run.seed == seed && run.status == StudyRunStatus::kDone;
  });
  return found == results.runs.end() ? nullptr : &*found;
}

FailureCount failures(const StudyResults& results, size_t method) {
  FailureCount count;
  for (const StudyRun& run : results.runs) {
    if (run.method != method || run.status != StudyRunStatus::kFailed) continue;
    if (count.runs++ == 0) count.reason = run.reason;
  }
  return count;
}

std::vector<CurvePoint> study_curve(const StudyResults& results, size_t method,
                                    StudyMetric metric) {
  const StudyMetricEntry& entry = study_metric_entry(metric);
  std::vector<CurvePoint> curve;
  for (const double budget : results.settings.budgets) {
    std::vector<double> samples, wall, cpu, errors;
    for_each_checkpoint(results, method, budget,
                        [&](const StudyCheckpoint& checkpoint, const auto&) {
                          samples.push_back(checkpoint.mean_samples);
                          wall.push_back(checkpoint.wall_s);
                          cpu.push_back(checkpoint.cpu_s);
                          errors.push_back(checkpoint.error.*entry.value);
                        });
    const std::optional<Estimate> error = geometric_mean_estimate(errors);
    if (!error) continue;
    curve.push_back(
        {budget, geometric_mean(samples), geometric_mean(wall), geometric_mean(cpu), *error});
  }
  return curve;
}

std::optional<Estimate> signed_bias(const StudyResults& results, size_t method, size_t budget) {
  std::vector<double> values;
  for_each_checkpoint(results, method, results.settings.budgets[budget],
                      [&](const StudyCheckpoint& checkpoint, const auto&) {
                        values.push_back(checkpoint.error.signed_bias);
                      });
  return mean_estimate(values);
}

std::optional<Estimate> error_slope(const StudyResults& results, size_t method, StudyMetric metric,
                                    StudyAxis axis) {
  std::vector<double> slopes;
  for (const StudyRun& run : results.runs) {
    if (run.method != method || run.status != StudyRunStatus::kDone) continue;
    std::vector<double> positions, errors;
    for (const LogPoint& p : log_curve(run, study_metric_entry(metric), axis)) {
      positions.push_back(p.position);
      errors.push_back(p.error);
    }
    if (errors.size() >= 2) slopes.push_back(least_squares_slope(positions, errors));
  }
  return mean_estimate(slopes);
}

std::optional<Speedup> equal_error_speedup(const StudyResults& results, size_t method,
                                           StudyMetric metric, StudyAxis axis, size_t budget) {
  const StudyMetricEntry& entry = study_metric_entry(metric);
  return mean_ratio(results, method, entry, axis, budget,
                    [&](const LogPoint& point, const LogCurve& baseline) {
                      std::optional<Crossing> crossing = position_at(baseline, point.error, entry);
                      if (crossing) crossing->value -= point.position;
                      return crossing;
                    });
}

std::optional<Estimate> equal_position_error_ratio(const StudyResults& results, size_t method,
                                                   StudyMetric metric, StudyAxis axis,
                                                   size_t budget) {
  const StudyMetricEntry& entry = study_metric_entry(metric);
  const std::optional<Speedup> ratio = mean_ratio(
      results, method, entry, axis, budget, [&](const LogPoint& point, const LogCurve& baseline) {
        std::optional<Crossing> other = error_at(baseline, point.position, entry);
        if (other) other->value = point.error - other->value;
        return other;
      });
  return ratio ? std::optional(ratio->ratio) : std::nullopt;
}

std::vector<CalibrationGroup> calibration(const StudyResults& results, size_t method) {
  struct Values {
    std::vector<double> samples, ratios;
  };
  std::map<long, Values> groups;  // key: log2 of the mean samples, rounded
  for (const StudyRun& run : results.runs) {
    if (run.method != method || run.status != StudyRunStatus::kDone) continue;
    for (const CalibrationPoint& point : run.calibration) {
      if (!(point.mean_samples > 0 && point.estimate > 0 && point.true_rms > 0)) continue;
      Values& values = groups[std::lround(std::log2(point.mean_samples))];
      values.samples.push_back(point.mean_samples);
      values.ratios.push_back(point.estimate / point.true_rms);
    }
  }
  std::vector<CalibrationGroup> list;
  for (const auto& [power, values] : groups) {
    list.push_back({geometric_mean(values.samples), *geometric_mean_estimate(values.ratios)});
  }
  return list;
}

std::optional<Estimate> neyman_fraction(const StudyResults& results, size_t method,
                                        StudyMetric metric, size_t budget) {
  if (!results.limits || results.methods[method].denoised) return std::nullopt;
  double limit = 0;
  if (metric == StudyMetric::kMse) limit = results.limits->mse;
  if (metric == StudyMetric::kRelMse) limit = results.limits->rel_mse;
  if (metric == StudyMetric::kDisplay) limit = results.limits->display;
  if (!(limit > 0)) return std::nullopt;
  const std::optional<Speedup> speedup =
      equal_error_speedup(results, method, metric, StudyAxis::kCpu, budget);
  if (!speedup) return std::nullopt;
  return map_estimate(speedup->ratio, [&](double ratio) { return ratio / limit; });
}

std::optional<FilterSummary> filter_summary(const StudyResults& results, size_t method,
                                            size_t budget) {
  std::vector<double> seconds, kept, ratios;
  for_each_checkpoint(results, method, results.settings.budgets[budget],
                      [&](const StudyCheckpoint& checkpoint, const auto&) {
                        if (!checkpoint.filter) return;
                        seconds.push_back(checkpoint.filter->cpu_s);
                        kept.push_back(checkpoint.filter->unchanged_fraction);
                        const double square = checkpoint.error.display_mse;
                        if (checkpoint.estimate && square > 0) {
                          ratios.push_back(*checkpoint.estimate / std::sqrt(square));
                        }
                      });
  if (kept.empty()) return std::nullopt;
  return FilterSummary{geometric_mean(seconds), mean_estimate(kept)->value,
                       geometric_mean_estimate(ratios)};
}

std::optional<Estimate> overhead(const StudyResults& results, size_t method, size_t budget) {
  std::vector<double> ratios;
  for_each_pair(results, method, budget,
                [&](const StudyCheckpoint& checkpoint, const StudyRun& baseline) {
                  const StudyCheckpoint* other = checkpoint_at(baseline, checkpoint.budget);
                  if (!other || !(other->cpu_s > 0) || checkpoint.samples == 0) return;
                  ratios.push_back(checkpoint.cpu_s / double(checkpoint.samples) /
                                   (other->cpu_s / double(other->samples)));
                });
  return geometric_mean_estimate(ratios);
}

}  // namespace emberline
