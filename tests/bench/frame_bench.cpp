// Times a whole frame and Embree's share of it. This is not a test. tests/bench/results has the
// figures.
//
//   frame_bench SCENE [--env FILE] [--look-from X,Y,Z --look-at X,Y,Z] [--size WxH] [--spp N]
//       [--threads N] [--repetitions N] [--json FILE]
//
// The variants run in turn (the frame, its rays alone, the frame on one thread, ...), so that other
// load affects all of them equally. The figures are medians, with the extremes.
#include <fmt/format.h>
#include <fmt/os.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <nlohmann/json.hpp>
#include <thread>

#include "bench/frame_benches.h"
#include "bench/ray_recorder.h"
#include "renderer/engine/process_usage.h"
#include "renderer/output/report.h"

namespace emberline::bench {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
  RenderOptions frame;
  int threads = 0;
  int repetitions = 5;
  double record_mib = 1024;
  std::string json;
};

Json to_json(const Spread& s) {
  return {{"median", s.median}, {"min", s.minimum}, {"max", s.maximum}};
}

void line(const char* name, const Spread& s, const char* unit) {
  fmt::print("{:<34}{:>10.4g}   {:.4g} to {:.4g}{}\n", name, s.median, s.minimum, s.maximum, unit);
}

// Figures of each repetition; the table and the JSON show their spreads.
struct Figures {
  std::vector<double> wall, cpu, first_sample, samples_per_s, samples_per_cpu_s, rays_per_s;
  std::vector<double> share, scaling, scaling_undisturbed, cpu_growth, used_of_threads;

  void add_frame(const FrameRun& run, int threads) {
    const double samples = double(run.counters.samples);
    wall.push_back(run.wall_s);
    cpu.push_back(run.cpu_s);
    first_sample.push_back(run.first_sample_s);
    samples_per_s.push_back(samples / run.wall_s);
    samples_per_cpu_s.push_back(samples / run.cpu_s);
    rays_per_s.push_back(double(run.counters.rays.total()) / run.wall_s);
    used_of_threads.push_back(run.cpu_s / (run.wall_s * threads));
  }
};

// Returns whether every thread had its own processor throughout, to 3 %.
bool undisturbed(const FrameRun& run, int threads) {
  return run.cpu_s > 0.97 * run.wall_s * threads;
}

// Returns the frame's samples per pixel, or fewer if a recording of all rays would not fit.
uint32_t recordable_spp(const Options& options, const BenchFrame& frame, const FrameRun& run) {
  const double bytes = double(run.counters.rays.total()) * double(RayRecorder::bytes_per_ray());
  const double limit = options.record_mib * 1048576;
  if (bytes <= limit) return *options.frame.spp;
  const double per_spp = bytes / *options.frame.spp;
  auto spp = uint32_t(limit / per_spp);
  if (spp >= 16) spp -= spp % 16;  // whole batches of the sampler
  if (spp == 0) {
    throw UsageError(
        fmt::format("one sample per pixel of {} pixels needs {:.0f} MiB to record; "
                    "raise --record-mib or make the frame smaller",
                    frame.pixels(), per_spp / 1048576));
  }
  return spp;
}

// Checks that the recording contains all rays of the frame, and that the rays have the same hits
// when they are traced again.
void check_recording(const RayRecorder& rays, const FrameRun& recorded) {
  const double counted = double(recorded.counters.rays.total());
  // A shadow ray of zero length is counted but not traced.
  if (double(rays.rays()) < 0.999 * counted || double(rays.rays()) > counted) {
    throw RenderError(fmt::format(
        "{} rays of {} were recorded: some are not traced by rtcIntersect1 or rtcOccluded1; "
        "make tests/bench/ray_recorder.cpp record their function, too",
        rays.rays(), counted));
  }
  if (const uint64_t different = rays.differences(); different > 0) {
    throw RenderError(fmt::format("{} of {} rays have another hit when they are traced again",
                                  different, rays.rays()));
  }
}

int run(const Options& options) {
  const BenchFrame frame(options.frame);
  const double started = process_age_seconds().value_or(0);
  const int threads = options.threads;
  const uint32_t spp = *options.frame.spp;

  const FrameRun warm = frame.run(threads, spp);
  const uint32_t share_spp = recordable_spp(options, frame, warm);
  RayRecorder rays;
  const FrameRun recorded = frame.run(threads, share_spp);
  rays.stop();
  check_recording(rays, recorded);

  Figures figures;
  for (int i = 0; i < options.repetitions; ++i) {
    const FrameRun run = frame.run(threads, spp);
    figures.add_frame(run, threads);
    const FrameRun part = share_spp == spp ? run : frame.run(threads, share_spp);
    const double embree = rays.replay().cpu_s - rays.replay_without_embree().cpu_s;
    figures.share.push_back(embree / part.cpu_s);
    if (threads > 1) {
      const FrameRun alone = frame.run(1, spp);
      figures.scaling.push_back(alone.wall_s / run.wall_s);
      if (undisturbed(run, threads) && undisturbed(alone, 1)) {
        figures.scaling_undisturbed.push_back(figures.scaling.back());
      }
      figures.cpu_growth.push_back(run.cpu_s / alone.cpu_s);
    }
  }

  const RayCounters& r = warm.counters.rays;
  const double load = [] {
    double average = 0;
    return getloadavg(&average, 1) == 1 ? average : 0.0;
  }();
  fmt::print("{} x {} pixels, {} spp, {} threads, {} repetitions; load average {:.1f}\n\n",
             options.frame.width, options.frame.height, spp, threads, options.repetitions, load);
  fmt::print("load {:.3f} s, build {:.3f} s, ready {:.3f} s after the process began\n",
             frame.load_s, frame.build_s, started);
  fmt::print("rays per sample: {:.2f} (camera 1, scatter {:.2f}, shadow {:.2f})\n\n",
             double(r.total()) / double(r.camera), double(r.scatter) / double(r.camera),
             double(r.shadow) / double(r.camera));
  line("samples per second", spread(figures.samples_per_s), "");
  line("samples per processor second", spread(figures.samples_per_cpu_s), "");
  line("rays per second", spread(figures.rays_per_s), "");
  line("first sample after", spread(figures.first_sample), " s of rendering");
  line("Embree's share of processor time", spread(figures.share), "");
  fmt::print("   {} rays of {} spp on {} threads, all with the same hits when traced again\n",
             rays.rays(), share_spp, rays.threads());
  line("processor time / (wall x threads)", spread(figures.used_of_threads), "");
  if (threads > 1) {
    line("speed-up over one thread, wall", spread(figures.scaling), "");
    line("processor time / one thread's", spread(figures.cpu_growth), "");
    if (figures.scaling_undisturbed.empty()) {
      fmt::print("   other work disturbed every repetition, so the speed-up is unknown\n");
    } else {
      line("speed-up where nothing else ran", spread(figures.scaling_undisturbed), "");
      fmt::print("   {} of {} repetitions\n", figures.scaling_undisturbed.size(),
                 options.repetitions);
    }
  }
  if (options.json.empty()) return 0;
  Json json = {{"load_average", load},
               {"load_s", frame.load_s},
               {"build_s", frame.build_s},
               {"ready_s", started},
               {"threads", threads},
               {"spp", spp},
               {"rays", {{"camera", r.camera}, {"scatter", r.scatter}, {"shadow", r.shadow}}}};
  const auto put = [&](const char* name, const std::vector<double>& values) {
    if (!values.empty()) json[name] = to_json(spread(values));
  };
  put("wall_s", figures.wall);
  put("cpu_s", figures.cpu);
  put("first_sample_s", figures.first_sample);
  put("samples_per_s", figures.samples_per_s);
  put("samples_per_cpu_s", figures.samples_per_cpu_s);
  put("rays_per_s", figures.rays_per_s);
  put("embree_share", figures.share);
  put("processor_use", figures.used_of_threads);
  put("speed_up", figures.scaling);
  put("speed_up_undisturbed", figures.scaling_undisturbed);
  put("cpu_growth", figures.cpu_growth);
  json["recorded"] = {{"rays", rays.rays()}, {"spp", share_spp}, {"threads", rays.threads()}};
  fmt::output_file(options.json).print("{}\n", json.dump(2));
  return 0;
}

}  // namespace

int run_frame_bench(int argc, char** argv) {
  Options options;
  options.frame.filter = "box";
  options.frame.width = 640;
  options.frame.height = 360;
  options.frame.spp = 16;
  options.frame.max_depth = 9;
  options.threads = int(std::min(2u, std::max(1u, std::thread::hardware_concurrency())));
  CLI::App app("Times a frame and Embree's share of it", "frame_bench");
  add_frame_options(&app, options.frame);
  app.add_option("--threads", options.threads, "worker threads")->check(CLI::Range(1, 4096));
  app.add_option("--repetitions", options.repetitions, "repetitions of everything, in turn")
      ->check(CLI::Range(1, 1000));
  app.add_option("--record-mib", options.record_mib,
                 "memory for recorded rays; if it is too small, fewer samples are recorded")
      ->check(CLI::Range(1.0, 1e6));
  app.add_option("--json", options.json, "write the figures here as well");
  CLI11_PARSE(app, argc, argv);
  return run(options);
}

}  // namespace emberline::bench
