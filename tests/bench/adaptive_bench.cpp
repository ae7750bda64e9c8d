// Measures the gain of adaptive sampling over uniform sampling on one scene, and compares it with
// the Neyman limit.
//
//   adaptive_bench SCENE [view and light as in frame_bench] [--size WxH] [--budgets 32,128,512]
//       [--methods nested/mse,nested/relmse,...] [--seeds N] [--reference-spp N]
//       [--cache FILE] [--json FILE]
//
// For each seed, the benchmark renders a uniform frame and a frame of each method in turn, all with
// the same budget. An error is the product of the differences to two independent references,
// (x - r1)(x - r2), whose expectation is the squared error without the references' own noise. A
// gain is in processor time to equal error: how much longer uniform sampling takes to reach the
// method's error, along uniform sampling's own curve of error against time (adaptive_errors.h). If
// adaptive sampling gives a pixel more samples than a reference has, the product is noisier than
// the error. So the benchmark also prints the variance between the frames of several seeds, which
// needs no reference but misses bias.
//
// The references give the variance v and the cost c of a sample for each pixel. For independent
// samples, the Neyman limit is mean(v) mean(c) / mean(sqrt(v c))^2. The second limit uses the
// measured errors of uniform frames and the slope of their curve.
#include <fmt/format.h>
#include <fmt/os.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "bench/adaptive_errors.h"
#include "bench/frame_benches.h"
#include "renderer/core/display_error.h"

namespace emberline::bench {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
  RenderOptions frame;
  std::string budgets = "32,128,512";
  std::string methods = "nested/mse,nested/relmse,nested/display";
  uint32_t seeds = 4, reference_spp = 2048;
  int threads = 0;
  std::string cache, json;
};

std::vector<std::string> split(const std::string& list) {
  std::vector<std::string> parts;
  std::stringstream stream(list);
  for (std::string part; std::getline(stream, part, ',');) parts.push_back(part);
  return parts;
}

struct Measured {
  std::array<double, kErrors> error{};
  double bias = 0;  // signed, of the frame's sum
  double cpu = 0, calibration = 0;
  RenderCounters counters;
};

Measured measure(const Floats& x, const Reference& r) {
  Measured m;
  double sum = 0, sum_reference = 0;
  for (size_t i = 0; i < x.size(); ++i) {
    const double a = double(r.a[i]), b = double(r.b[i]), v = double(x[i]);
    const double mean = (a + b) / 2;
    m.error[kMse] += (v - a) * (v - b);
    m.error[kRelMse] += (v - a) * (v - b) * r.weight(kRelMse, i);
    const double shown = double(display_value(x[i]));
    m.error[kDisplay] +=
        (shown - double(display_value(r.a[i]))) * (shown - double(display_value(r.b[i])));
    sum += v;
    sum_reference += mean;
  }
  for (double& e : m.error) e /= double(x.size());
  m.bias = (sum - sum_reference) / sum_reference;
  return m;
}

struct Run {
  Measured measured;
  Floats rgb;
};

Run run(const BenchFrame& frame, const Options& o, const FrameSampling& s,
        const Reference& reference) {
  ImageSink image(frame, s.aovs);
  const FrameRun frame_run = frame.run(o.threads, s, image);
  Floats picture = image.rgb();
  Measured m = measure(picture, reference);
  m.cpu = frame_run.cpu_s;
  m.counters = frame_run.counters;
  if (frame_run.error_estimate) {
    m.calibration = *frame_run.error_estimate / std::sqrt(std::max(1e-30, m.error[kDisplay]));
  }
  return {m, std::move(picture)};
}

// Returns the part of the errors that is variance, from the deviations of the seeds' frames from
// their mean.
std::array<double, kErrors> variance_between(const std::vector<Run>& runs, const Reference& r) {
  std::array<double, kErrors> sums{};
  if (runs.size() < 2) return sums;
  const double n = double(runs.size());
  for (size_t i = 0; i < r.a.size(); ++i) {
    double mean = 0, shown_mean = 0;
    for (const Run& run : runs) {
      mean += double(run.rgb[i]) / n;
      shown_mean += double(display_value(run.rgb[i])) / n;
    }
    double squares = 0, shown_squares = 0;
    for (const Run& run : runs) {
      squares += square(double(run.rgb[i]) - mean);
      shown_squares += square(double(display_value(run.rgb[i])) - shown_mean);
    }
    sums[kMse] += squares;
    sums[kRelMse] += squares * r.weight(kRelMse, i);
    sums[kDisplay] += shown_squares;
  }
  for (double& sum : sums) sum /= (n - 1) * double(r.a.size());
  return sums;
}

struct Mean {
  Measured mean;
  std::array<double, kErrors> variance{};  // between the seeds; 0 if there is only one
  double bias_se = 0;
  double samples = 0, rays = 0;
};

Mean average(const std::vector<Run>& runs, const Reference& reference) {
  Mean out;
  out.variance = variance_between(runs, reference);
  const double n = double(runs.size());
  double squares = 0;
  for (const Run& run : runs) {
    const Measured& m = run.measured;
    for (size_t e = 0; e < kErrors; ++e) out.mean.error[e] += m.error[e] / n;
    out.mean.bias += m.bias / n;
    out.mean.cpu += m.cpu / n;
    out.mean.calibration += m.calibration / n;
    out.samples += double(m.counters.samples) / n;
    out.rays += double(m.counters.rays.total()) / n;
    out.mean.counters.max_samples = std::max(out.mean.counters.max_samples, m.counters.max_samples);
    squares += m.bias * m.bias / n;
  }
  out.bias_se =
      std::sqrt(std::max(0.0, squares - out.mean.bias * out.mean.bias) / std::max(1.0, n - 1));
  return out;
}

// Uniform sampling's errors and processor time at each budget.
class UniformCurve {
 public:
  struct Point {
    std::array<double, kErrors> error;
    double cpu;
  };
  std::map<uint32_t, Point> points;

  // Returns how fast an error falls at a budget, which is as samples^-slope. The slope is taken
  // towards the next budget, or from the previous budget at the end of the curve. It is 1 for a
  // single budget. It is at least kLeastSlope, since the error of a few frames with rare highlights
  // may seem to rise.
  double slope(uint32_t budget, Error error) const {
    if (points.size() == 1) return 1.0;
    auto next = std::next(points.find(budget));
    if (next == points.end()) --next;
    const auto& [spp, point] = *next;
    const auto& [spp_before, before] = *std::prev(next);
    constexpr double kLeastSlope = 0.1;
    return std::max(kLeastSlope, std::log(before.error[error] / point.error[error]) /
                                     std::log(double(spp) / double(spp_before)));
  }

  // Returns the processor time at which the error reaches `value`, by log-log interpolation.
  // Extrapolates beyond the last budget.
  double time(Error error, double value) const {
    auto from = points.begin();
    while (std::next(from) != points.end() && std::next(std::next(from)) != points.end() &&
           value < std::next(from)->second.error[error]) {
      ++from;
    }
    const auto& [budget, point] = *from;
    return point.cpu * std::pow(point.error[error] / value, 1 / slope(budget, error));
  }
};

// A method is ESTIMATOR/ALLOCATION[/unbiased].
FrameSampling adaptive_sampling(const std::string& method, uint32_t budget, uint32_t seed) {
  std::stringstream parts(method);
  std::string estimator, allocation, unbiased;
  std::getline(parts, estimator, '/');
  std::getline(parts, allocation, '/');
  std::getline(parts, unbiased, '/');
  FrameSampling s;
  s.driver = "adaptive";
  s.spp = budget;
  s.seed = seed;
  s.adaptive.estimator = find_estimator(estimator).name;
  s.streams = find_estimator(estimator).streams;
  if (!allocation.empty()) {
    s.adaptive.allocation =
        find_named(error_metric_table(), "--methods", "allocation", allocation).value;
  }
  s.adaptive.budget = budget;
  s.adaptive.unbiased = unbiased == "unbiased";
  return s;
}

// Returns the gains by error and by variance, in processor time and in rays. Gains in rays do not
// depend on the load of the machine.
Json gains(const Mean& m, const Mean& uniform, const UniformCurve& curve, uint32_t budget,
           Error e) {
  const double error = m.mean.error[e], spread = m.variance[e];
  const double time = curve.time(e, error), spread_time = curve.time(e, spread);
  const double rays = uniform.mean.cpu * m.rays / uniform.rays;
  return {{"error", error},
          {"uniform", curve.points.at(budget).error[e]},
          {"variance", spread},
          {"gain", time / m.mean.cpu},
          {"ray_gain", time / rays},
          {"spread_gain", spread_time / m.mean.cpu},
          {"spread_ray_gain", spread_time / rays}};
}

}  // namespace

int run_adaptive_bench(int argc, char** argv) {
  Options o;
  o.frame.width = 320;
  o.frame.height = 180;
  CLI::App app("Measures the gain of adaptive sampling");
  add_frame_options(&app, o.frame);
  app.add_option("--budgets", o.budgets, "list of average samples per pixel");
  app.add_option("--methods", o.methods, "list of ESTIMATOR/ALLOCATION[/unbiased]");
  app.add_option("--seeds", o.seeds, "number of frames of each kind");
  app.add_option("--reference-spp", o.reference_spp, "samples per pixel of both references");
  app.add_option("--cache", o.cache, "file that keeps the references");
  app.add_option("--threads", o.threads, "[all]");
  app.add_option("--json", o.json, "write the figures");
  CLI11_PARSE(app, argc, argv);
  if (o.threads == 0) o.threads = int(std::max(1u, std::thread::hardware_concurrency()));

  const BenchFrame frame(o.frame);
  const Reference reference = make_reference(frame, o.reference_spp, o.threads, o.cache);
  std::map<uint32_t, Mean> uniform;
  std::map<uint32_t, std::map<std::string, Mean>> methods;
  std::map<uint32_t, UniformErrors> errors;
  UniformCurve curve;
  for (const std::string& text : split(o.budgets)) {
    const auto budget = uint32_t(std::stoul(text));
    errors[budget] = measure_uniform(frame, budget, o.threads, o.cache);
    std::vector<Run> uniform_runs;
    std::map<std::string, std::vector<Run>> runs;
    for (uint32_t seed = 0; seed < o.seeds; ++seed) {
      FrameSampling s;
      s.spp = budget;
      s.seed = seed;
      uniform_runs.push_back(run(frame, o, s, reference));
      for (const std::string& method : split(o.methods)) {
        runs[method].push_back(run(frame, o, adaptive_sampling(method, budget, seed), reference));
      }
    }
    uniform[budget] = average(uniform_runs, reference);
    for (const auto& [method, list] : runs) methods[budget][method] = average(list, reference);
    curve.points[budget].cpu = uniform[budget].mean.cpu;
    for (const Error e : {kMse, kRelMse, kDisplay}) {
      // The measured variance is more precise than the distance from a reference, but too small for
      // the display error, where rare bright samples also bias the pixels that missed them.
      curve.points[budget].error[e] =
          e == kDisplay ? uniform[budget].mean.error[e] : mean_error(errors[budget], reference, e);
    }
  }
  Json json;
  for (const auto& [budget, u] : uniform) {
    Json& limits = json["limits"][std::to_string(budget)];
    fmt::print("\n{} spp: uniform {:.3g} s, bias {:+.2f} +- {:.2f} %\n", budget, u.mean.cpu,
               100 * u.mean.bias, 100 * u.bias_se);
    for (const Error e : {kMse, kRelMse, kDisplay}) {
      const double slope = curve.slope(budget, e);
      const Json& limit = limits[kErrorNames[e]] = {
          {"independent", independent_limit(reference, e)},
          {"stratified", stratified_limit(errors[budget], budget, reference, e, slope)},
          {"slope", slope}};
      fmt::print("  {:<8} error {:.4g} ({:.4g}) falls as samples^-{:.2f}; limit {:.3f}, {:.3f}\n",
                 kErrorNames[e], curve.points[budget].error[e], u.mean.error[e], slope,
                 limit["independent"].get<double>(), limit["stratified"].get<double>());
    }
    for (const auto& [method, m] : methods[budget]) {
      Json row;
      fmt::print("  {:<24} spp {:.1f} max {} time x{:.3f} rays x{:.3f}", method,
                 m.samples / double(frame.pixels()), m.mean.counters.max_samples,
                 m.mean.cpu / u.mean.cpu, m.rays / u.rays);
      for (const Error e : {kMse, kRelMse, kDisplay}) {
        row[kErrorNames[e]] = gains(m, u, curve, budget, e);
        fmt::print(" | {} x{:.3f} gain {:.3f} ({:.3f}) by spread {:.3f}", kErrorNames[e],
                   m.mean.error[e] / curve.points[budget].error[e],
                   row[kErrorNames[e]]["gain"].get<double>(),
                   row[kErrorNames[e]]["ray_gain"].get<double>(),
                   row[kErrorNames[e]]["spread_gain"].get<double>());
      }
      fmt::print(" | bias {:+.2f} +- {:.2f} % | calibration {:.2f}\n", 100 * m.mean.bias,
                 100 * m.bias_se, m.mean.calibration);
      row["bias"] = m.mean.bias;
      row["bias_se"] = m.bias_se;
      row["calibration"] = m.mean.calibration;
      row["time_ratio"] = m.mean.cpu / u.mean.cpu;
      row["spp"] = m.samples / double(frame.pixels());
      json["methods"][std::to_string(budget)][method] = row;
    }
  }
  if (!o.json.empty()) std::ofstream(o.json) << json.dump(1) << "\n";
  return 0;
}

}  // namespace emberline::bench
