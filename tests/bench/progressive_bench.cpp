// Measures how soon a progressive driver shows a picture, how soon it stops, and its cost compared
// with `bucket`. This is not a test. tests/bench/results has the figures.
//
//   progressive_bench SCENE --driver NAME [--env FILE] [--look-from X,Y,Z --look-at X,Y,Z]
//       [--size WxH] [--spp N] [--threads N] [--repetitions N]
//
// The two drivers run in pairs and ratios are taken within pairs, so that other load affects both
// drivers equally. The figures are medians, with the extremes.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <thread>

#include "bench/bench_frame.h"
#include "bench/frame_benches.h"
#include "renderer/core/errors.h"
#include "renderer/engine/render_sink.h"
#include "renderer/film/film.h"

namespace emberline::bench {
namespace {

struct Options {
  RenderOptions frame;
  int threads = 2;
  int repetitions = 5;
  uint32_t spp() const { return frame.spp.value_or(64); }
};

// Resolves and times the picture at several moments, as a window would.
class ObserverSink final : public RenderSink {
 public:
  explicit ObserverSink(uint64_t pixels) : rgba_(4 * pixels) {
    std::ranges::fill(rgba_, 1.0f);  // touches the memory, as in a window
  }
  void tile_finished(const FilmTile& /*tile*/) override {}
  void picture_changed(const JobProgress& progress, const LivePicture& picture) override {
    if (next_ == kMoments || progress.completion < kCompletions[next_]) return;
    const double before = wall_clock(), cpu_before = process_cpu();
    picture.resolve(rgba_);
    resolve_s_[next_] = wall_clock() - before;
    resolve_cpu_s_[next_] = process_cpu() - cpu_before;
    displayed_s_[next_] = wall_clock() - start_ - observed_s_;
    observed_s_ += next_ == 0 ? 0.0 : resolve_s_[next_];  // the first resolve() is part of the
                                                          // latency
    ++next_;
  }
  std::optional<uint64_t> next_picture_at() const override {
    if (next_ == kMoments) return std::nullopt;
    return uint64_t(std::ceil(kCompletions[next_] * double(rgba_.size() / 4)));
  }

  static constexpr size_t kMoments = 5;
  static constexpr double kCompletions[kMoments] = {0.0, 1.0 / 64, 0.25, 0.5, 1.0};
  double displayed_s(size_t moment) const { return displayed_s_[moment]; }
  double resolve_s(size_t moment) const { return resolve_s_[moment]; }
  double resolve_cpu_s(size_t moment) const { return resolve_cpu_s_[moment]; }

 private:
  const double start_ = wall_clock();
  std::vector<float> rgba_;
  size_t next_ = 0;
  double observed_s_ = 0;
  double displayed_s_[kMoments] = {}, resolve_s_[kMoments] = {}, resolve_cpu_s_[kMoments] = {};
};

class NullSink final : public RenderSink {
 public:
  void tile_finished(const FilmTile& /*tile*/) override {}
  void picture_changed(const JobProgress& /*now*/, const LivePicture& /*picture*/) override {
    ++pauses_;
  }
  int pauses() const { return pauses_; }

 private:
  int pauses_ = 0;
};

FrameSampling sampling_of(const std::string& driver, uint32_t spp) {
  FrameSampling sampling;
  sampling.driver = driver;
  sampling.spp = spp;
  sampling.adaptive.budget = spp;
  if (driver == "adaptive") sampling.streams = find_estimator(sampling.adaptive.estimator).streams;
  return sampling;
}

void line(const std::string& name, const std::vector<double>& values, double scale,
          const char* unit) {
  const Spread s = spread(values);
  fmt::print("{:<44}{:>9.4g}   {:.4g} to {:.4g}{}\n", name, s.median * scale, s.minimum * scale,
             s.maximum * scale, unit);
}

void measure_pictures(const Options& options, const BenchFrame& frame) {
  std::vector<double> shown[ObserverSink::kMoments], resolve[ObserverSink::kMoments],
      resolve_cpu[ObserverSink::kMoments];
  for (int i = 0; i < options.repetitions; ++i) {
    ObserverSink observer(frame.pixels());
    frame.run(options.threads, sampling_of(options.frame.driver, 1), observer);
    for (size_t m = 0; m < ObserverSink::kMoments; ++m) {
      shown[m].push_back(observer.displayed_s(m));
      resolve[m].push_back(observer.resolve_s(m));
      resolve_cpu[m].push_back(observer.resolve_cpu_s(m));
    }
  }
  const char* names[] = {"first pause", "1/64 of the pixels", "1/4", "1/2", "all"};
  for (size_t m = 0; m < ObserverSink::kMoments; ++m) {
    line(fmt::format("picture after {}", names[m]), shown[m], 1e3, " ms");
    line("  of it, resolving", resolve[m], 1e3, " ms");
    line("  and its processor time, all threads", resolve_cpu[m], 1e3, " ms");
  }
}

void measure_stops(const Options& options, const BenchFrame& frame) {
  std::vector<double> latency;
  for (int i = 0; i < 4 * options.repetitions; ++i) {
    NullSink null_sink;
    std::stop_source stop;
    double requested = 0;
    std::thread timer([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(10 + 37 * i % 500));
      requested = wall_clock();
      stop.request_stop();
    });
    const FrameRun run = frame.run(options.threads, sampling_of(options.frame.driver, 1u << 20),
                                   null_sink, stop.get_token());
    timer.join();
    latency.push_back(run.returned - requested);
  }
  line("from a stop request to the return", latency, 1e3, " ms");
}

void measure_overhead(const Options& options, const BenchFrame& frame) {
  std::vector<double> cpu, wall, pauses;
  const auto timed = [&](const std::string& name) {
    NullSink null_sink;
    const FrameRun run = frame.run(options.threads, sampling_of(name, options.spp()), null_sink);
    if (name == options.frame.driver) pauses.push_back(null_sink.pauses());
    return run;
  };
  for (int i = 0; i < options.repetitions; ++i) {
    // The order of the two drivers alternates.
    const FrameRun before = i % 2 == 0 ? timed("bucket") : FrameRun{};
    const FrameRun driver = timed(options.frame.driver);
    const FrameRun bucket = i % 2 == 0 ? before : timed("bucket");
    cpu.push_back(driver.cpu_s / bucket.cpu_s);
    wall.push_back(driver.wall_s / bucket.wall_s);
  }
  const std::string spp = fmt::format("{} spp, {} / bucket", options.spp(), options.frame.driver);
  line(spp + ", processor time", cpu, 1, "");
  line(spp + ", wall time", wall, 1, "");
  line("pauses of a frame without a viewer", pauses, 1, "");
}

}  // namespace

int run_progressive_bench(int argc, char** argv) {
  Options options;
  options.frame.driver = "bisection";
  options.frame.filter = "box";
  CLI::App app("Times a progressive driver", "progressive_bench");
  add_frame_options(&app, options.frame);
  app.add_option("--threads", options.threads, "worker threads")->check(CLI::Range(1, 4096));
  app.add_option("--repetitions", options.repetitions, "repetitions of everything")
      ->check(CLI::Range(1, 10000));
  CLI11_PARSE(app, argc, argv);
  const BenchFrame frame(options.frame);
  fmt::print("{}  {}x{}  {}  {} threads, medians of {}\n", options.frame.scene, options.frame.width,
             options.frame.height, options.frame.driver, options.threads, options.repetitions);
  measure_pictures(options, frame);
  measure_stops(options, frame);
  if (options.spp() > 1) measure_overhead(options, frame);
  return 0;
}

}  // namespace emberline::bench
