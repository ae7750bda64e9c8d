#include "renderer/statistics/study/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <optional>
#include <span>

#include "renderer/core/readable.h"
#include "renderer/statistics/html_page.h"
#include "renderer/statistics/study_summary.h"
#include "renderer/statistics/svg_chart.h"

namespace emberline {
namespace {

using Tone = PageCell::Tone;

// The metrics that charts and comparisons show; the table of errors shows all metrics.
constexpr std::array kChartMetrics = {StudyMetric::kRelMseTrimmed, StudyMetric::kRelMse,
                                      StudyMetric::kMse, StudyMetric::kDisplay, StudyMetric::kFlip};

bool any_checkpoint(const StudyResults& results) {
  return std::ranges::any_of(results.runs,
                             [](const auto& run) { return !run.checkpoints.empty(); });
}

// Returns a text such as "1.92 [1.8, 2.05]". If runs are missing, appends the number of runs.
std::string format_estimate(const Estimate& e, const StudyResults& results) {
  std::string text = readable_number(e.value);
  if (e.low && e.high) {
    // The space is U+00A0, so that the interval is not split between lines.
    text += fmt::format(" [{},\u00a0{}]", readable_number(*e.low), readable_number(*e.high));
  }
  if (e.runs < results.settings.seeds) {
    text += fmt::format(" ({} of {} runs)", e.runs, results.settings.seeds);
  }
  return text;
}

PageCell cell(const std::optional<Estimate>& e, const StudyResults& results) {
  return e ? PageCell(format_estimate(*e, results)) : PageCell("none");
}

// Colours the cell as better or worse if the interval excludes 1.
PageCell ratio_cell(const Estimate& e, const StudyResults& results, bool above_is_better,
                    const std::string& more = "") {
  Tone tone = Tone::kPlain;
  if (e.low && *e.low > 1) tone = above_is_better ? Tone::kGood : Tone::kBad;
  if (e.high && *e.high < 1) tone = above_is_better ? Tone::kBad : Tone::kGood;
  return {format_estimate(e, results) + more, tone};
}

// Returns "8 s" or "64 spp".
std::string budget_text(const StudySettings& settings, double budget) {
  return settings.by_time ? readable_seconds(budget)
                          : fmt::format("{} spp", readable_number(budget, 6));
}

std::string metric_name(StudyMetric metric) { return std::string(study_metric_entry(metric).name); }

// Makes a table with a row for each method except `excluded`. A row has the method's name, followed
// by make_cell(method, column) for each column.
template <typename Cell>
PageTable method_table(const StudyResults& results, const std::string& caption,
                       const std::vector<std::string>& columns, const Cell& make_cell,
                       std::optional<size_t> excluded = std::nullopt) {
  PageTable table{caption, {{"method"}}, {}};
  for (const std::string& name : columns) table.columns.push_back({name, true});
  for (size_t m = 0; m < results.methods.size(); ++m) {
    if (m == excluded) continue;
    std::vector<PageCell>& row = table.rows.emplace_back();
    row.push_back(results.methods[m].name);
    for (size_t c = 0; c < columns.size(); ++c) row.push_back(make_cell(m, c));
  }
  return table;
}

std::vector<std::string> metric_names(std::span<const StudyMetric> metrics) {
  std::vector<std::string> names;
  for (const StudyMetric metric : metrics) names.push_back(metric_name(metric));
  return names;
}

std::vector<std::string> budget_names(const StudySettings& settings) {
  std::vector<std::string> names;
  for (const double budget : settings.budgets) {
    names.push_back(budget_text(settings, budget));
  }
  return names;
}

std::string seeds_text(const StudySettings& s) {
  return s.seeds == 1 ? std::string("a single seed, without confidence intervals")
                      : fmt::format("means over {} seeds with 95 % confidence intervals", s.seeds);
}

// ---- speedups ----------------------------------------------------------------------------------

PageCell speedup_cell(const StudyResults& results, size_t method, StudyMetric metric,
                      StudyAxis axis, size_t budget) {
  const auto speedup = equal_error_speedup(results, method, metric, axis, budget);
  if (!speedup) return "none";
  return ratio_cell(speedup->ratio, results, true, speedup->extrapolated > 0 ? "\u00a0*" : "");
}

// ---- curves ------------------------------------------------------------------------------------

ChartPoint chart_point(double x, const Estimate& y) {
  return {x, y.value, y.low.value_or(NAN), y.high.value_or(NAN)};
}

Markup curve_chart(const StudyResults& results, StudyMetric metric, StudyAxis axis) {
  const StudyMetricEntry& entry = study_metric_entry(metric);
  LineChart chart;
  chart.title =
      fmt::format("{} against {}", entry.name, axis == StudyAxis::kSamples ? "samples" : "time");
  chart.x = {axis == StudyAxis::kSamples
                 ? std::string("samples per pixel")
                 : fmt::format("seconds of rendering, {} threads", results.settings.threads),
             AxisScale::kLog};
  chart.y = {std::string(entry.name), AxisScale::kLog};
  for (size_t m = 0; m < results.methods.size(); ++m) {
    ChartSeries series{results.methods[m].name};
    series.spread = ChartSpread::kBand;
    for (const CurvePoint& point : study_curve(results, m, metric)) {
      series.points.push_back(chart_point(position(point, axis), point.error));
    }
    chart.series.push_back(std::move(series));
  }
  return line_chart(chart);
}

PageTable slopes(const StudyResults& results, StudyAxis axis) {
  return method_table(
      results,
      axis == StudyAxis::kSamples ? "Fitted slopes against samples" : "Fitted slopes against time",
      metric_names(kChartMetrics), [&](size_t m, size_t c) {
        return cell(error_slope(results, m, kChartMetrics[c], axis), results);
      });
}

// ---- bias --------------------------------------------------------------------------------------

PageCell bias_cell(const StudyResults& results, size_t method, size_t budget) {
  const auto bias = signed_bias(results, method, budget);
  if (!bias) return "none";
  std::string text = fmt::format("{:+.3f}\u00a0%", 100 * bias->value);
  if (!bias->low || !bias->high) return text;
  text += fmt::format(" [{:+.3f},\u00a0{:+.3f}]", 100 * *bias->low, 100 * *bias->high);
  // A bias of up to two standard errors of the reference's sum may come from the noise of the
  // reference.
  const double tolerance = 2 * results.reference.noise_bias;
  const bool biased = *bias->low > tolerance || *bias->high < -tolerance;
  return {text, biased ? Tone::kBad : Tone::kPlain};
}

// ---- sections -----------------------------------------------------------------------------------

// If a section has nothing to show, it says why: no run is finished, there is only one seed, or the
// study did not render the reference.

void add_warnings(HtmlPage& page, const StudyResults& results) {
  if (!results.complete) {
    page.warning(
        "The study was stopped before all runs were finished. This page shows the finished runs; "
        "the same command continues with the rest.");
  }
  size_t failed = 0;
  for (const StudyRun& run : results.runs) failed += run.status == StudyRunStatus::kFailed;
  if (failed > 0) {
    page.warning(fmt::format("{} of {} runs failed; they are listed below under \"Runs\".", failed,
                             results.runs.size()));
  }
}

void add_speedups(HtmlPage& page, const StudyResults& results) {
  page.section("Speedup at equal error");
  const auto baseline = baseline_method(results);
  if (!baseline || !any_checkpoint(results) || results.settings.budgets.empty()) {
    page.paragraph("No run of the baseline has finished, so there is nothing to compare with.");
    return;
  }
  page.paragraph(fmt::format(
      "The time that {} needs to reach a method's error, divided by that method's "
      "time. If the value is above 1, the method is faster. The tables show {}. Runs are compared "
      "seed by seed. A value is coloured if its interval excludes 1. A * means that for some seeds "
      "the error is beyond the baseline's checkpoints, so the baseline's curve was "
      "extrapolated.",
      results.methods[*baseline].name, seeds_text(results.settings)));
  if (results.methods.size() < 2) {
    page.paragraph("The baseline is the only method.");
    return;
  }
  const size_t last = results.settings.budgets.size() - 1;
  const std::string largest = budget_text(results.settings, results.settings.budgets[last]);
  const auto add_by_metric = [&](const char* time, StudyAxis axis) {
    page.table(method_table(
        results, fmt::format("{}, at {}", time, largest), metric_names(kChartMetrics),
        [&](size_t m, size_t c) { return speedup_cell(results, m, kChartMetrics[c], axis, last); },
        baseline));
  };
  add_by_metric("Processor time", StudyAxis::kCpu);
  add_by_metric("Wall time", StudyAxis::kWall);
  if (last == 0) return;
  constexpr StudyMetric kMetric = StudyMetric::kRelMseTrimmed;
  page.table(method_table(
      results, "Processor time to equal " + metric_name(kMetric), budget_names(results.settings),
      [&](size_t m, size_t b) { return speedup_cell(results, m, kMetric, StudyAxis::kCpu, b); },
      baseline));
}

void add_curves(HtmlPage& page, const StudyResults& results) {
  page.section("Error against time and samples");
  if (!any_checkpoint(results)) {
    page.paragraph("No run has finished.");
    return;
  }
  page.paragraph(fmt::format("Both scales are logarithmic. The curves show {}.",
                             seeds_text(results.settings)));
  for (const StudyMetric metric : kChartMetrics) {
    const std::string summary(study_metric_entry(metric).summary);
    page.figures(
        std::vector<PageFigure>{{curve_chart(results, metric, StudyAxis::kWall), summary + "."},
                                {curve_chart(results, metric, StudyAxis::kSamples), ""}});
  }
  page.paragraph(
      "With independent samples, mean squared errors fall with a slope of -1 and their roots with "
      "-1/2. Well-distributed samples do better until discontinuities of the picture limit them.");
  page.table(slopes(results, StudyAxis::kWall));
  page.table(slopes(results, StudyAxis::kSamples));
}

void add_errors(HtmlPage& page, const StudyResults& results) {
  if (!any_checkpoint(results) || results.settings.budgets.empty()) return;
  page.section("Errors at the largest budget");
  const double budget = results.settings.budgets.back();
  std::vector<std::string> names;
  for (const StudyMetricEntry& entry : study_metric_table()) names.emplace_back(entry.name);
  page.table(method_table(results, "At " + budget_text(results.settings, budget), names,
                          [&](size_t m, size_t c) -> PageCell {
                            const std::vector<CurvePoint> curve =
                                study_curve(results, m, study_metric_table()[c].metric);
                            const auto at = std::ranges::find(curve, budget, &CurvePoint::budget);
                            return at == curve.end()
                                       ? PageCell("none")
                                       : PageCell(format_estimate(at->error, results));
                          }));

  page.heading("Signed bias");
  page.paragraph(
      fmt::format("The light that each method gains (+) or loses (-) compared with the reference. "
                  "The sum of the reference has a standard error of {:.3f} %. A value is coloured "
                  "if its interval, widened by two of these standard errors, excludes 0.",
                  100 * results.reference.noise_bias));
  page.table(method_table(results, "", budget_names(results.settings),
                          [&](size_t m, size_t b) { return bias_cell(results, m, b); }));
}

void add_calibration(HtmlPage& page, const StudyResults& results) {
  page.section("Calibration of the estimates");
  LineChart chart;
  chart.title = "Estimated over true RMS error";
  chart.x = {"samples per pixel", AxisScale::kLog};
  chart.y = {"estimated / true", AxisScale::kLog};
  double min = INFINITY, max = 0;
  for (size_t m = 0; m < results.methods.size(); ++m) {
    ChartSeries series{results.methods[m].name, {}, int(m)};
    for (const CalibrationGroup& group : calibration(results, m)) {
      series.points.push_back(chart_point(group.mean_samples, group.ratio));
      min = std::min(min, group.mean_samples);
      max = std::max(max, group.mean_samples);
    }
    if (!series.points.empty()) chart.series.push_back(std::move(series));
  }
  if (chart.series.empty()) {
    page.paragraph(
        "No method estimated its error, so there is nothing to compare with the true error.");
    return;
  }
  ChartSeries exact{"exact", {{min, 1}, {max, 1}}, 6};
  exact.markers = false;
  chart.series.push_back(std::move(exact));
  page.figures(std::vector<PageFigure>{
      {line_chart(chart),
       "The driver's error estimate for the displayed picture between rounds, divided by the error "
       "against the reference. Above 1 the driver is too careful and renders too long; below 1 it "
       "is too optimistic."}});
}

void add_denoising(HtmlPage& page, const StudyResults& results) {
  const auto denoised = [](const StudyMethod& method) { return method.denoised; };
  if (!any_checkpoint(results) || std::ranges::none_of(results.methods, denoised)) return;
  page.section("Denoising");
  page.paragraph(
      "Times and errors above are for the denoised picture and include the filter. The tables "
      "below show the filter's processor time, its error estimate divided by the true error, and "
      "the share of pixels that it left unfiltered.");
  for (size_t m = 0; m < results.methods.size(); ++m) {
    PageTable table{
        results.methods[m].name,
        {{"budget"}, {"processor time", true}, {"estimate : truth", true}, {"unfiltered", true}},
        {}};
    for (size_t b = 0; b < results.settings.budgets.size(); ++b) {
      const std::optional<FilterSummary> filter = filter_summary(results, m, b);
      if (!filter) continue;
      table.rows.push_back({budget_text(results.settings, results.settings.budgets[b]),
                            readable_seconds(filter->cpu_s), cell(filter->estimate_ratio, results),
                            readable_percent(filter->unchanged_fraction)});
    }
    if (!table.rows.empty()) page.table(table);
  }
}

void add_limits(HtmlPage& page, const StudyResults& results) {
  if (!any_checkpoint(results) || results.settings.budgets.empty()) return;
  const size_t last = results.settings.budgets.size() - 1;
  page.section("Possible gain and overhead");
  constexpr std::array kNeymanMetrics = {StudyMetric::kMse, StudyMetric::kRelMse,
                                         StudyMetric::kDisplay};
  if (results.limits) {
    const NeymanLimits& limits = *results.limits;
    page.paragraph(fmt::format(
        "The Neyman limit: with independent samples, no distribution of samples can reach equal "
        "error faster than the uniform one by more than a factor of {} (mse), {} (relmse), {} "
        "(display_mse). The table shows the speedup in processor time as a share of that limit.",
        readable_number(limits.mse), readable_number(limits.rel_mse),
        readable_number(limits.display)));
    page.table(method_table(
        results, "Share of the limit", metric_names(kNeymanMetrics), [&](size_t m, size_t c) {
          return cell(neyman_fraction(results, m, kNeymanMetrics[c], last), results);
        }));
  } else {
    page.paragraph(
        "The Neyman limit is unknown: the reference is a picture without the variance of its "
        "pixels.");
  }
  page.table(method_table(results, "Overhead",
                          {"processor time per sample, relative to the baseline"},
                          [&](size_t m, size_t) -> PageCell {
                            const auto ratio = overhead(results, m, last);
                            return ratio ? ratio_cell(*ratio, results, false) : PageCell("none");
                          }));
  page.paragraph(
      "A value above 1 comes from the driver's own work and from samples in pixels with longer "
      "paths.");
}

void add_runs(HtmlPage& page, const StudyResults& results) {
  page.section("Runs");
  page.table(method_table(
      results, "", {"finished", "failed", "not run"}, [&](size_t m, size_t c) -> PageCell {
        const auto count_runs = [&](StudyRunStatus status) {
          return size_t(std::ranges::count_if(results.runs, [&](const StudyRun& run) {
            return run.method == m && run.status == status;
          }));
        };
        const size_t done = count_runs(StudyRunStatus::kDone);
        const size_t failed = count_runs(StudyRunStatus::kFailed);
        if (c == 0) return std::to_string(done);
        if (c == 1) return {std::to_string(failed), failed > 0 ? Tone::kBad : Tone::kPlain};
        const size_t seeds = results.settings.seeds;
        return std::to_string(seeds - std::min(seeds, done + failed));
      }));
  PageTable failures{"Failed", {{"method"}, {"seed", true}, {"reason"}}, {}};
  for (const StudyRun& run : results.runs) {
    if (run.status != StudyRunStatus::kFailed || run.method >= results.methods.size()) continue;
    failures.rows.push_back(
        {results.methods[run.method].name, std::to_string(run.seed), {run.reason, Tone::kBad}});
  }
  if (!failures.rows.empty()) page.table(failures);
}

void add_settings(HtmlPage& page, const StudyResults& results) {
  const StudyReference& r = results.reference;
  page.section("Reference");
  if (!r.file.empty()) {
    page.paragraph("Read from " + r.file + ". Any noise in it is part of every error.");
  } else {
    page.paragraph(fmt::format(
        "Rendered by {} with {}, {} samples per pixel in total, seeds {} and {}.{}", r.driver,
        r.sampler, readable_count(r.samples_per_pixel), r.seeds[0], r.seeds[1],
        r.two_halves ? " It is stored as two halves, so that its noise can be subtracted from all "
                       "mean squared errors."
                     : ""));
    page.paragraph(fmt::format(
        "Noise of the mean of both halves: mse {}, relmse {}, display_mse {}, bias {:.3f} %.",
        readable_number(r.noise_mse), readable_number(r.noise_rel_mse),
        readable_number(r.noise_display_mse), 100 * r.noise_bias));
  }
  page.paragraph(fmt::format("relmse divides by the squared radiance plus {}.",
                             readable_number(r.rel_mse_epsilon)));

  const StudySettings& s = results.settings;
  page.section("To run this study again");
  page.code(s.command_line);
  std::string budgets;
  for (const double b : s.budgets) {
    budgets += (budgets.empty() ? "" : ", ") + budget_text(s, b);
  }
  PageTable settings{"", {{"setting"}, {"value"}}, {}};
  settings.rows = {{"scene", s.scene},
                   {"picture", fmt::format("{} x {}", s.width, s.height)},
                   {"budgets", budgets},
                   {"seeds", s.seeds == 0 ? std::string("none")
                                          : fmt::format("{} to {}", s.first_seed,
                                                        uint64_t(s.first_seed) + s.seeds - 1)},
                   {"threads", std::to_string(s.threads)},
                   {"baseline", s.baseline}};
  for (const auto& [key, value] : s.frame) settings.rows.push_back({key, value});
  page.table(settings);
  PageTable versions{"", {{"library"}, {"version"}}, {}};
  for (const auto& [name, version] : s.versions) versions.rows.push_back({name, version});
  if (!versions.rows.empty()) page.table(versions);
}

std::string summary(const StudySettings& s) {
  std::string budgets = "no budget";
  if (!s.budgets.empty()) {
    budgets = fmt::format("{} to {} {}", budget_text(s, s.budgets.front()),
                          budget_text(s, s.budgets.back()),
                          s.by_time ? "of rendering" : "(samples per pixel)");
  }
  return fmt::format("{} x {} pixels, {}, {} {}, {} {}", s.width, s.height, budgets, s.seeds,
                     s.seeds == 1 ? "seed" : "seeds", s.threads,
                     s.threads == 1 ? "thread" : "threads");
}

}  // namespace

std::string study_page(const StudyResults& results, const std::string& folder) {
  const std::string scene = std::filesystem::path(results.settings.scene).filename().string();
  HtmlPage page("Speed against error: " + scene, summary(results.settings));
  add_warnings(page, results);
  add_speedups(page, results);
  add_curves(page, results);
  add_errors(page, results);
  add_study_pictures(page, results, folder);
  add_calibration(page, results);
  add_denoising(page, results);
  add_limits(page, results);
  add_runs(page, results);
  add_settings(page, results);
  return page.finish();
}

}  // namespace emberline
