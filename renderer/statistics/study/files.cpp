#include "renderer/statistics/study/files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>

#include "renderer/statistics/study_summary.h"

namespace emberline {
namespace {

using Json = nlohmann::ordered_json;

// Returns null for a missing number. Json also writes non-finite numbers as null.
Json number(const std::optional<double>& value) { return value ? Json(*value) : Json(); }

double read_finite(const JsonReader& value) {
  return value.number(-std::numeric_limits<double>::max(), std::numeric_limits<double>::max());
}
double read_number(const JsonReader& value) {
  return value.is_null() ? std::numeric_limits<double>::quiet_NaN() : read_finite(value);
}

std::string csv_number(double value) {
  return std::isfinite(value) ? fmt::format("{}", value) : std::string();
}
std::string csv_number(const std::optional<double>& value) {
  return value ? csv_number(*value) : std::string();
}

// Quotes the text if RFC 4180 requires it.
std::string csv_text(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

Json checkpoint_json(const StudyCheckpoint& c) {
  Json json = {{"budget", c.budget},
               {"samples", c.samples},
               {"mean_samples", c.mean_samples},
               {"wall_s", c.wall_s},
               {"cpu_s", c.cpu_s}};
  for (const StudyMetricEntry& metric : study_metric_table()) {
    json[std::string(metric.name)] = c.error.*metric.value;
  }
  json["signed_bias"] = c.error.signed_bias;
  json["estimate"] = number(c.estimate);
  json["filter_cpu_s"] = c.filter ? Json(c.filter->cpu_s) : Json();
  json["kept_share"] = c.filter ? Json(c.filter->unchanged_fraction) : Json();
  return json;
}

StudyCheckpoint read_checkpoint(const JsonReader& entry) {
  StudyCheckpoint c;
  c.budget = read_finite(entry["budget"]);
  c.samples = entry["samples"].whole_number(0, std::numeric_limits<uint64_t>::max());
  c.mean_samples = read_finite(entry["mean_samples"]);
  c.wall_s = read_finite(entry["wall_s"]);
  c.cpu_s = read_finite(entry["cpu_s"]);
  for (const StudyMetricEntry& metric : study_metric_table()) {
    c.error.*metric.value = read_number(entry[std::string(metric.name)]);
  }
  c.error.signed_bias = read_number(entry["signed_bias"]);
  if (!entry["estimate"].is_null()) c.estimate = read_finite(entry["estimate"]);
  if (!entry["filter_cpu_s"].is_null()) {
    c.filter = {read_finite(entry["filter_cpu_s"]), read_finite(entry["kept_share"])};
  }
  return c;
}

Json run_object(const StudyRun& run) {
  Json json = {{"seed", run.seed},
               {"status", run.status == StudyRunStatus::kDone ? "done" : "failed"},
               {"reason", run.reason},
               {"non_finite_samples", run.non_finite_samples},
               {"checkpoints", Json::array()},
               {"calibration", Json::array()}};
  for (const StudyCheckpoint& c : run.checkpoints) {
    json["checkpoints"].push_back(checkpoint_json(c));
  }
  for (const CalibrationPoint& p : run.calibration) {
    json["calibration"].push_back(
        {{"mean_samples", p.mean_samples}, {"estimate", p.estimate}, {"true_rms", p.true_rms}});
  }
  return json;
}

Json estimate_json(const std::optional<Estimate>& e) {
  if (!e) return nullptr;
  return {
      {"value", e->value}, {"low", number(e->low)}, {"high", number(e->high)}, {"runs", e->runs}};
}

std::optional<Estimate> ratio_of(const std::optional<Speedup>& speedup) {
  if (!speedup) return std::nullopt;
  return speedup->ratio;
}

constexpr std::pair<const char*, StudyAxis> kAxes[] = {
    {"samples", StudyAxis::kSamples}, {"wall", StudyAxis::kWall}, {"cpu", StudyAxis::kCpu}};

Json metric_summary(const StudyResults& r, size_t method, StudyMetric metric) {
  Json json;
  json["curve"] = Json::array();
  for (const CurvePoint& point : study_curve(r, method, metric)) {
    json["curve"].push_back({{"budget", point.budget},
                             {"mean_samples", point.mean_samples},
                             {"wall_s", point.wall_s},
                             {"cpu_s", point.cpu_s},
                             {"error", estimate_json(point.error)}});
  }
  for (const auto& [name, axis] : kAxes) {
    json["slope"][name] = estimate_json(error_slope(r, method, metric, axis));
    Json& speedups = json["equal_error_speedup"][name] = Json::array();
    Json& ratios = json["equal_position_error_ratio"][name] = Json::array();
    for (size_t b = 0; b < r.settings.budgets.size(); ++b) {
      const std::optional<Speedup> speedup = equal_error_speedup(r, method, metric, axis, b);
      Json entry = estimate_json(ratio_of(speedup));
      if (speedup) entry["extrapolated"] = speedup->extrapolated;
      speedups.push_back(entry);
      ratios.push_back(estimate_json(equal_position_error_ratio(r, method, metric, axis, b)));
    }
  }
  json["neyman_fraction"] = Json::array();
  for (size_t b = 0; b < r.settings.budgets.size(); ++b) {
    json["neyman_fraction"].push_back(estimate_json(neyman_fraction(r, method, metric, b)));
  }
  return json;
}

Json method_summary(const StudyResults& r, size_t method) {
  const FailureCount failed = failures(r, method);
  Json json = {{"method", r.methods[method].name}, {"failed_runs", failed.runs},
               {"reason", failed.reason},          {"overhead", Json::array()},
               {"signed_bias", Json::array()},     {"filter", Json::array()},
               {"calibration", Json::array()}};
  for (size_t b = 0; b < r.settings.budgets.size(); ++b) {
    json["signed_bias"].push_back(estimate_json(signed_bias(r, method, b)));
    json["overhead"].push_back(estimate_json(overhead(r, method, b)));
    const std::optional<FilterSummary> filter = filter_summary(r, method, b);
    if (!filter) continue;
    json["filter"].push_back({{"budget", r.settings.budgets[b]},
                              {"cpu_s", filter->cpu_s},
                              {"kept_share", filter->unchanged_fraction},
                              {"estimate_ratio", estimate_json(filter->estimate_ratio)}});
  }
  for (const CalibrationGroup& group : calibration(r, method)) {
    json["calibration"].push_back(
        {{"mean_samples", group.mean_samples}, {"ratio", estimate_json(group.ratio)}});
  }
  for (const StudyMetricEntry& metric : study_metric_table()) {
    json["metrics"][std::string(metric.name)] = metric_summary(r, method, metric.metric);
  }
  return json;
}

Json pairs_json(const std::vector<std::pair<std::string, std::string>>& pairs) {
  return Json::object_t(pairs.begin(), pairs.end());
}

Json settings_json(const StudySettings& s) {
  return {{"scene", s.scene},
          {"command", s.command_line},
          {"size", {s.width, s.height}},
          {"frame", pairs_json(s.frame)},
          {"budgets_in", s.by_time ? "seconds" : "samples per pixel"},
          {"budgets", s.budgets},
          {"first_seed", s.first_seed},
          {"seeds", s.seeds},
          {"threads", s.threads},
          {"baseline", s.baseline}};
}

Json reference_json(const StudyReference& r) {
  return {{"file", r.file},
          {"driver", r.driver},
          {"sampler", r.sampler},
          {"samples_per_pixel", r.samples_per_pixel},
          {"seeds", r.seeds},
          {"two_halves", r.two_halves},
          {"noise",
           {{"mse", r.noise_mse},
            {"relmse", r.noise_rel_mse},
            {"display_mse", r.noise_display_mse},
            {"bias", r.noise_bias}}},
          {"relmse_epsilon", r.rel_mse_epsilon},
          {"exr", r.exr},
          {"png", r.png}};
}

Json methods_json(const StudyResults& results) {
  Json list = Json::array();
  for (const StudyMethod& m : results.methods) {
    list.push_back({{"name", m.name},
                    {"driver", m.driver},
                    {"estimator", m.estimator},
                    {"allocation", m.allocation},
                    {"unbiased", m.unbiased},
                    {"planned", m.planned},
                    {"denoised", m.denoised},
                    {"sampler", m.sampler},
                    {"pictures",
                     {{"exr", m.pictures.exr},
                      {"png", m.pictures.png},
                      {"flip", m.pictures.flip_png},
                      {"seed", m.pictures.seed},
                      {"mean_samples", m.pictures.mean_samples},
                      {"wall_s", m.pictures.wall_s}}}});
  }
  return list;
}

std::string dumped(const Json& json) {
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

// Returns "1.23", "1.23 [1.1, 1.4]" or "-".
std::string text_of(const std::optional<Estimate>& e) {
  if (!e) return "-";
  std::string text = fmt::format("{:.3g}", e->value);
  if (e->low && e->high) text += fmt::format(" [{:.3g}, {:.3g}]", *e->low, *e->high);
  return text;
}

using Rows = std::vector<std::vector<std::string>>;

// Returns a table with a row for each denoised method and budget; "" if no method is denoised.
std::string denoised_table(const StudyResults& r) {
  Rows rows = {{"method", "budget", "relmse", "trimmed", "display_mse", "flip", "speedup by relmse",
                "filter, s", "estimate : truth", "unfiltered"}};
  for (size_t m = 0; m < r.methods.size(); ++m) {
    for (size_t b = 0; b < r.settings.budgets.size(); ++b) {
      const std::optional<FilterSummary> filter = filter_summary(r, m, b);
      if (!filter) continue;
      std::vector<std::string>& row = rows.emplace_back();
      row = {r.methods[m].name, fmt::format("{}", r.settings.budgets[b])};
      for (const StudyMetric metric : {StudyMetric::kRelMse, StudyMetric::kRelMseTrimmed,
                                       StudyMetric::kDisplay, StudyMetric::kFlip}) {
        const std::vector<CurvePoint> curve = study_curve(r, m, metric);
        const auto at = std::ranges::find(curve, r.settings.budgets[b], &CurvePoint::budget);
        row.push_back(at == curve.end() ? "-" : fmt::format("{:.3g}", at->error.value));
      }
      const auto speedup = equal_error_speedup(r, m, StudyMetric::kRelMse, StudyAxis::kCpu, b);
      row.insert(row.end(), {text_of(ratio_of(speedup)), fmt::format("{:.3g}", filter->cpu_s),
                             text_of(filter->estimate_ratio),
                             fmt::format("{:.0f} %", 100 * filter->unchanged_fraction)});
    }
  }
  return rows.size() == 1 ? ""
                          : "\ndenoised, including the filter's time\n\n" + aligned_table(rows);
}

}  // namespace

std::string study_csv(const StudyResults& results, std::optional<int> frame) {
  std::string text = frame ? "frame," : "";
  text +=
      "method,driver,estimator,allocation,unbiased,planned,denoised,sampler,seed,status,reason,"
      "budget,samples,mean_samples";
  const auto out = std::back_inserter(text);
  for (const StudyMetricEntry& metric : study_metric_table()) {
    fmt::format_to(out, ",{}", metric.name);
  }
  text += ",signed_bias,estimate,wall_s,cpu_s,filter_cpu_s,kept_share\n";
  for (const StudyRun& run : results.runs) {
    const StudyMethod& m = results.methods[run.method];
    const bool failed = run.status == StudyRunStatus::kFailed;
    const std::string start =
        fmt::format("{}{},{},{},{},{},{},{},{},{},{},{}", frame ? fmt::format("{},", *frame) : "",
                    csv_text(m.name), m.driver, m.estimator, m.allocation,
                    m.unbiased ? "yes" : "no", m.planned ? "yes" : "no", m.denoised ? "yes" : "no",
                    m.sampler, run.seed, failed ? "failed" : "done", csv_text(run.reason));
    if (failed) text += start + std::string(study_metric_table().size() + 9, ',') + "\n";
    for (const StudyCheckpoint& c : run.checkpoints) {
      fmt::format_to(out, "{},{},{},{}", start, c.budget, c.samples, c.mean_samples);
      for (const StudyMetricEntry& metric : study_metric_table()) {
        fmt::format_to(out, ",{}", csv_number(c.error.*metric.value));
      }
      fmt::format_to(out, ",{},{},{},{}", csv_number(c.error.signed_bias), csv_number(c.estimate),
                     c.wall_s, c.cpu_s);
      text += c.filter ? fmt::format(",{},{}\n", c.filter->cpu_s, c.filter->unchanged_fraction)
                       : ",,\n";
    }
  }
  return text;
}

std::string study_json(const StudyResults& results) {
  Json json = {{"settings", settings_json(results.settings)},
               {"complete", results.complete},
               {"reference", reference_json(results.reference)},
               {"neyman_limits", nullptr},
               {"methods", methods_json(results)},
               {"runs", Json::array()},
               {"summary", Json::array()},
               {"versions", pairs_json(results.settings.versions)}};
  if (const auto& limits = results.limits) {
    json["neyman_limits"] = {
        {"mse", limits->mse}, {"relmse", limits->rel_mse}, {"display_mse", limits->display}};
  }
  for (const StudyRun& run : results.runs) {
    Json object = {{"method", results.methods[run.method].name}};
    object.update(run_object(run));
    json["runs"].push_back(object);
  }
  for (size_t m = 0; m < results.methods.size(); ++m) {
    json["summary"].push_back(method_summary(results, m));
  }
  return dumped(json);
}

std::string study_table(const StudyResults& r) {
  const StudySettings& s = r.settings;
  if (s.budgets.empty()) return "";
  std::string text = fmt::format(
      "at {} {}, with 95 % intervals over {} seed{}; speedup in processor time at equal error, "
      "against {}\n\n",
      s.budgets.back(), s.by_time ? "seconds" : "samples per pixel", s.seeds,
      s.seeds == 1 ? "" : "s", s.baseline);
  Rows rows = {{"method", "mse", "relmse", "speedup by mse", "speedup by relmse", "bias %"}};
  std::string failed_runs;
  const size_t last = s.budgets.size() - 1;
  for (size_t m = 0; m < r.methods.size(); ++m) {
    const auto error = [&](StudyMetric metric) -> std::optional<Estimate> {
      const std::vector<CurvePoint> curve = study_curve(r, m, metric);
      if (curve.empty() || curve.back().budget != s.budgets[last]) return std::nullopt;
      return curve.back().error;
    };
    const auto speedup = [&](StudyMetric metric) {
      return text_of(ratio_of(equal_error_speedup(r, m, metric, StudyAxis::kCpu, last)));
    };
    const FailureCount failed = failures(r, m);
    if (failed.runs > 0 && !error(StudyMetric::kMse)) {
      rows.push_back({r.methods[m].name, "failed"});
    }
    if (failed.runs > 0) {
      failed_runs += fmt::format("{}: {} run{} failed: {}\n", r.methods[m].name, failed.runs,
                                 failed.runs == 1 ? "" : "s", failed.reason);
    }
    if (!error(StudyMetric::kMse)) continue;
    std::optional<Estimate> bias = signed_bias(r, m, last);
    if (bias) bias = map_estimate(*bias, [](double share) { return 100 * share; });
    rows.push_back({r.methods[m].name, text_of(error(StudyMetric::kMse)),
                    text_of(error(StudyMetric::kRelMse)), speedup(StudyMetric::kMse),
                    speedup(StudyMetric::kRelMse), text_of(bias)});
  }
  return text + aligned_table(rows) + denoised_table(r) +
         (failed_runs.empty() ? "" : "\n" + failed_runs);
}

std::string aligned_table(const Rows& rows) {
  std::vector<size_t> widths(rows.front().size(), 0);
  for (const auto& row : rows) {
    for (size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], row[c].size());
  }
  std::string text;
  for (const auto& row : rows) {
    for (size_t c = 0; c < row.size(); ++c) {
      const bool last = c + 1 == row.size();
      text += last ? row[c] + "\n" : fmt::format("{:<{}}", row[c], widths[c] + 2);
    }
  }
  return text;
}

std::string run_json(const StudyRun& run, std::string_view key) {
  Json json = {{"key", key}};
  json.update(run_object(run));
  return dumped(json);
}

StudyRun parse_run(const JsonReader& root, std::string_view key) {
  if (root["key"].text() != key) root["key"].throw_expected("the key of this study");
  StudyRun run;
  run.seed = uint32_t(root["seed"].whole_number(0, std::numeric_limits<uint32_t>::max()));
  if (root["status"].text() != "done") root["status"].throw_expected("\"done\"");
  run.reason = root["reason"].text();
  run.non_finite_samples =
      root["non_finite_samples"].whole_number(0, std::numeric_limits<uint64_t>::max());
  const JsonReader checkpoints = root["checkpoints"], calibration = root["calibration"];
  if (checkpoints.size() == 0) checkpoints.throw_expected("at least one checkpoint");
  for (size_t i = 0; i < checkpoints.size(); ++i) {
    run.checkpoints.push_back(read_checkpoint(checkpoints[i]));
  }
  for (size_t i = 0; i < calibration.size(); ++i) {
    const JsonReader point = calibration[i];
    run.calibration.push_back({read_finite(point["mean_samples"]), read_finite(point["estimate"]),
                               read_number(point["true_rms"])});
  }
  return run;
}

}  // namespace emberline
