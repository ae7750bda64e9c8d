// What adaptive sampling gains on one scene, against uniform sampling and against the Neyman limit.
//
//   adaptive_bench SCENE [view and light as in frame_bench] [--size WxH] [--budgets 32,128,512]
//       [--methods nested/mse,nested/relmse,...] [--seeds N] [--reference-spp N]
//       [--cache FILE] [--json FILE]
//
// Each method's frame and a uniform one of the same budget are rendered in turn, for each seed.
// Errors are products of the differences to two independent references, (x - r1)(x - r2), whose
// expectation is the squared error without the references' own noise. Gains are of processor time
// to equal error: how much longer uniform sampling needs for the method's error, along its own
// curve of error against time.
// Where adaptive sampling gives a pixel more samples than a reference has, those products are
// noisier than what they measure. Beside them stands the spread between the frames of several
// seeds, which needs no reference but does not see a bias.
//
// The limit is Neyman's: with variance v of a sample and cost c of a sample (both per pixel, from
// the references), mean(v) mean(c) / mean(sqrt(v c))^2. v is once the spread of samples, as if they
// were independent, and once the variance that the uniform frames of the budget really have.
#include <fmt/format.h>
#include <fmt/os.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "bench/bench_frame.h"
#include "renderer/app/option_values.h"
#include "renderer/core/errors.h"
#include "renderer/drivers/adaptive/error_metric.h"

namespace emberline::bench {
namespace {

using Json = nlohmann::ordered_json;
using Floats = std::vector<float>;

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

// Keeps a frame's channels, interleaved.
class ImageObserver final : public FrameObserver {
 public:
  ImageObserver(const BenchFrame& frame, const AovSet& aovs)
      : width_(frame.width()), channels_(film_channels(aovs).size()) {
    values.resize(frame.pixels() * channels_);
  }
  void tile_finished(const FilmTile& tile) override {
    std::vector<float> pixels;
    tile.resolve(pixels);
    const Rect& r = tile.rect();
    const std::lock_guard lock(mutex_);
    for (int y = r.y0; y < r.y1; ++y) {
      const size_t row = size_t(r.width()) * channels_;
      std::copy_n(&pixels[size_t(y - r.y0) * row], row,
                  &values[(size_t(y) * size_t(width_) + size_t(r.x0)) * channels_]);
    }
  }
  Floats plane(size_t channel) const {
    Floats out(values.size() / channels_);
    for (size_t i = 0; i < out.size(); ++i) out[i] = values[i * channels_ + channel];
    return out;
  }
  Floats rgb() const {
    Floats out;
    for (size_t i = 0; i < values.size(); i += channels_) {
      out.insert(out.end(), &values[i], &values[i] + 3);
    }
    return out;
  }
  Floats values;

 private:
  const int width_;
  const size_t channels_;
  std::mutex mutex_;
};

struct Reference {
  Floats a, b;         // rgb
  Floats variance;     // of a sample, rgb
  Floats cost;         // seconds a sample
  double epsilon = 0;  // of relMSE
};

Reference make_reference(const BenchFrame& frame, const Options& o) {
  Reference r;
  const size_t n = frame.pixels();
  if (std::ifstream in(o.cache, std::ios::binary); in) {
    for (auto [plane, size] :
         {std::pair{&r.a, 3 * n}, {&r.b, 3 * n}, {&r.variance, 3 * n}, {&r.cost, n}}) {
      plane->resize(size);
      in.read(reinterpret_cast<char*>(plane->data()), std::streamsize(size * sizeof(float)));
    }
    if (!in || in.peek() != EOF) throw RenderError(o.cache + ": not of this frame; remove it");
  } else {
    FrameSampling s;
    s.spp = o.reference_spp;
    s.aovs = AovSet::parse("variance,time");
    const auto spp = float(o.reference_spp);
    for (const uint32_t half : {0u, 1u}) {
      s.seed = 0x5eed0u + half;
      ImageObserver image(frame, s.aovs);
      frame.run(o.threads, s, image);
      (half == 0 ? r.a : r.b) = image.rgb();
      const Floats seconds = image.plane(8);
      r.variance.resize(3 * n);
      r.cost.resize(n, 1e30f);
      for (size_t i = 0; i < n; ++i) {
        for (size_t c = 0; c < 3; ++c) {
          r.variance[3 * i + c] += 0.5f * spp * image.values[9 * i + 5 + c];
        }
        // The less disturbed of the two.
        r.cost[i] = std::min(r.cost[i], seconds[i] / spp);
      }
    }
    if (!o.cache.empty()) {
      std::ofstream out(o.cache, std::ios::binary);
      for (const Floats* plane : {&r.a, &r.b, &r.variance, &r.cost}) {
        out.write(reinterpret_cast<const char*>(plane->data()),
                  std::streamsize(plane->size() * sizeof(float)));
      }
    }
  }
  double sum = 0;
  for (size_t i = 0; i < 3 * n; ++i) sum += double(r.a[i]) + double(r.b[i]);
  r.epsilon = 0.01 * std::pow(sum / (6 * double(n)), 2);
  return r;
}

enum Error : int { kMse, kRelMse, kDisplay, kErrors };
constexpr const char* kErrorNames[] = {"mse", "relmse", "display"};

double weight_of(int error, double mean, double epsilon) {
  if (error == kRelMse) return 1 / (mean * mean + epsilon);
  if (error == kDisplay) return double(error_weight(ErrorMetric::kDisplay, 0, float(mean), 1e-3f));
  return 1;
}

struct Measured {
  std::array<double, kErrors> error{};
  double bias = 0;  // signed, of the frame's sum
  double cpu = 0, calibration = 0;
  FrameCounters counters;
};

Measured measure(const Floats& x, const Reference& r) {
  Measured m;
  double sum = 0, sum_reference = 0;
  for (size_t i = 0; i < x.size(); ++i) {
    const double a = double(r.a[i]), b = double(r.b[i]), v = double(x[i]);
    const double mean = (a + b) / 2;
    m.error[kMse] += (v - a) * (v - b);
    m.error[kRelMse] += (v - a) * (v - b) * weight_of(kRelMse, mean, r.epsilon);
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

// mean(v) mean(c) / mean(sqrt(v c))^2, v per pixel the mean over channels of weight x variance.
double neyman_limit(const Floats& variance, const Reference& r, int error) {
  double v_sum = 0, c_sum = 0, root_sum = 0;
  const size_t n = r.cost.size();
  for (size_t i = 0; i < n; ++i) {
    double v = 0;
    for (size_t c = 0; c < 3; ++c) {
      const double mean = 0.5 * (double(r.a[3 * i + c]) + double(r.b[3 * i + c]));
      v += std::max(0.0, double(variance[3 * i + c])) * weight_of(error, mean, r.epsilon) / 3;
    }
    v_sum += v;
    c_sum += double(r.cost[i]);
    root_sum += std::sqrt(v * double(r.cost[i]));
  }
  return v_sum * c_sum / (root_sum * root_sum);
}

struct Run {
  Measured measured;
  Floats rgb;
};

Run run(const BenchFrame& frame, const Options& o, const FrameSampling& s,
        const Reference& reference) {
  ImageObserver image(frame, s.aovs);
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

// The errors' variance part, from how far the frames of different seeds are from their mean.
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
    const double reference = 0.5 * (double(r.a[i]) + double(r.b[i]));
    sums[kMse] += squares;
    sums[kRelMse] += squares * weight_of(kRelMse, reference, r.epsilon);
    sums[kDisplay] += shown_squares;
  }
  for (double& sum : sums) sum /= (n - 1) * double(r.a.size());
  return sums;
}

struct Mean {
  Measured mean;
  std::array<double, kErrors> variance{};  // between the seeds; 0 with one
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

// The time at which uniform sampling reaches `error`, along straight lines between its budgets in
// logarithms, continued beyond them. `error_of` tells a budget's.
template <typename ErrorOf>
double uniform_time(const std::map<uint32_t, Mean>& uniform, const ErrorOf& error_of,
                    double error) {
  std::vector<std::pair<double, double>> curve;  // log error, log time
  for (const auto& [spp, m] : uniform) {
    curve.push_back({std::log(error_of(m)), std::log(m.mean.cpu)});
  }
  if (curve.size() == 1) return std::exp(curve[0].second + curve[0].first - std::log(error));
  size_t k = 0;
  while (k + 2 < curve.size() && std::log(error) < curve[k + 1].first) ++k;
  const auto [e0, t0] = curve[k];
  const auto [e1, t1] = curve[k + 1];
  return std::exp(t0 + (t1 - t0) * (std::log(error) - e0) / (e1 - e0));
}

int run_bench(int argc, char** argv) {
  Options o;
  o.frame.filter = std::string(kDefaultFilter);
  o.frame.width = 320;
  o.frame.height = 180;
  CLI::App app("what adaptive sampling gains");
  add_frame_options(&app, o.frame);
  app.add_option("--budgets", o.budgets, "average samples per pixel, a list");
  app.add_option("--methods", o.methods, "ESTIMATOR/ALLOCATION[/unbiased], a list");
  app.add_option("--seeds", o.seeds, "frames of each kind");
  app.add_option("--reference-spp", o.reference_spp, "of each of the two references");
  app.add_option("--cache", o.cache, "file that keeps the references");
  app.add_option("--threads", o.threads, "[all]");
  app.add_option("--json", o.json, "write the figures");
  CLI11_PARSE(app, argc, argv);
  if (o.threads == 0) o.threads = int(std::max(1u, std::thread::hardware_concurrency()));

  const BenchFrame frame(o.frame);
  const Reference reference = make_reference(frame, o);
  std::map<uint32_t, Mean> uniform;
  std::map<uint32_t, std::map<std::string, Mean>> methods;
  Json json;
  for (const std::string& text : split(o.budgets)) {
    const auto budget = uint32_t(std::stoul(text));
    Floats variance(reference.variance.size(), 0.0f);
    std::vector<Run> uniform_runs;
    std::map<std::string, std::vector<Run>> runs;
    for (uint32_t seed = 0; seed < o.seeds; ++seed) {
      FrameSampling s;
      s.spp = budget;
      s.seed = seed;
      uniform_runs.push_back(run(frame, o, s, reference));
      const Floats& rgb = uniform_runs.back().rgb;
      for (size_t i = 0; i < rgb.size(); ++i) {
        variance[i] +=
            (rgb[i] - reference.a[i]) * (rgb[i] - reference.b[i]) * float(budget) / float(o.seeds);
      }
      for (const std::string& method : split(o.methods)) {
        std::stringstream parts(method);
        std::string estimator, allocation, unbiased;
        std::getline(parts, estimator, '/');
        std::getline(parts, allocation, '/');
        std::getline(parts, unbiased, '/');
        s.driver = "adaptive";
        s.adaptive.estimator = find_estimator(estimator).name;
        s.streams = find_estimator(estimator).streams;
        if (!allocation.empty()) s.adaptive.allocation = parse_error_metric(allocation);
        s.adaptive.budget = budget;
        s.adaptive.unbiased = unbiased == "unbiased";
        runs[method].push_back(run(frame, o, s, reference));
      }
    }
    uniform[budget] = average(uniform_runs, reference);
    for (const auto& [method, list] : runs) methods[budget][method] = average(list, reference);
    for (int e = 0; e < kErrors; ++e) {
      json["limits"][text][kErrorNames[e]] = {
          {"independent", neyman_limit(reference.variance, reference, e)},
          {"measured", neyman_limit(variance, reference, e)}};
    }
  }
  for (const auto& [budget, u] : uniform) {
    fmt::print(
        "\n{} spp: uniform mse {:.4g} relmse {:.4g} display rms {:.4g}, {:.3g} s, bias {:+.2f} +- "
        "{:.2f} %\n",
        budget, u.mean.error[kMse], u.mean.error[kRelMse], std::sqrt(u.mean.error[kDisplay]),
        u.mean.cpu, 100 * u.mean.bias, 100 * u.bias_se);
    for (int e = 0; e < kErrors; ++e) {
      const Json& limit = json["limits"][std::to_string(budget)][kErrorNames[e]];
      fmt::print("  limit {:<8} {:.3f} (as measured {:.3f})\n", kErrorNames[e],
                 limit["independent"].get<double>(), limit["measured"].get<double>());
    }
    for (const auto& [method, m] : methods[budget]) {
      fmt::print("  {:<24} spp {:.1f} max {} time x{:.3f} rays x{:.3f} us/ray x{:.3f}", method,
                 m.samples / double(frame.pixels()), m.mean.counters.max_samples,
                 m.mean.cpu / u.mean.cpu, m.rays / u.rays,
                 m.mean.cpu / u.mean.cpu * u.rays / m.rays);
      Json row;
      for (int e = 0; e < kErrors; ++e) {
        const double error = m.mean.error[size_t(e)];
        const double time = uniform_time(
            uniform, [&](const Mean& x) { return x.mean.error[size_t(e)]; }, error);
        const double spread_time = uniform_time(
            uniform, [&](const Mean& x) { return x.variance[size_t(e)]; }, m.variance[size_t(e)]);
        const double gain = time / m.mean.cpu, spread_gain = spread_time / m.mean.cpu;
        // The same with rays for time: for machines that are busy.
        const double ray_gain = time / u.mean.cpu / (m.rays / u.rays);
        const double spread_ray_gain = spread_time / u.mean.cpu / (m.rays / u.rays);
        fmt::print(" | {} x{:.3f} gain {:.3f} ({:.3f}) by spread {:.3f} ({:.3f})", kErrorNames[e],
                   error / u.mean.error[size_t(e)], gain, ray_gain, spread_gain, spread_ray_gain);
        row[kErrorNames[e]] = {{"error", error},
                               {"uniform", u.mean.error[size_t(e)]},
                               {"gain", gain},
                               {"ray_gain", ray_gain},
                               {"variance", m.variance[size_t(e)]},
                               {"spread_gain", spread_gain},
                               {"spread_ray_gain", spread_ray_gain}};
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

}  // namespace
}  // namespace emberline::bench

int main(int argc, char** argv) {
  try {
    return emberline::bench::run_bench(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "adaptive_bench: %s\n", error.what());
    return EXIT_FAILURE;
  }
}
