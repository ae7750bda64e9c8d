// Measures the cost of light groups and the latency of relighting. This is not a test.
// tests/bench/results and integrators/README.md have the figures.
//
//   light_groups_bench SCENE [--env FILE] [--look-from X,Y,Z --look-at X,Y,Z] [--size WxH]
//       [--lamps N] [--spp N] [--threads N] [--repetitions N]
//
// Adds N point lights on a circle above the scene. Frames with and without groups run in pairs, in
// either order, and the ratios are taken within pairs.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>

#include "bench/bench_frame.h"
#include "bench/frame_benches.h"
#include "renderer/core/constants.h"
#include "renderer/core/errors.h"
#include "renderer/description/framing.h"
#include "renderer/description/scene_edits.h"
#include "renderer/engine/render_job.h"
#include "renderer/film/film.h"
#include "renderer/scene/light_groups.h"
#include "support/edits.h"

namespace emberline::bench {
namespace {

struct Options {
  RenderOptions frame;
  int lamps = 7;
  int threads = 2;
  int repetitions = 9;
};

class NullSink final : public RenderSink {
  void tile_finished(const FilmTile& /*tile*/) override {}
};

// Adds lamps around the scene at twice its radius. Each lamp lights the inside as much as a sky of
// radiance 1 / count.
void add_lamps(int count, SceneDescription& scene) {
  const WorldBounds bounds = world_bounds(scene);
  const double distance = bounds.isEmpty() ? 1.0 : 2.0 * bounds.radius();
  const Vec3d center = bounds.isEmpty() ? Vec3d(0.0) : bounds.center();
  for (int i = 0; i < count; ++i) {
    PunctualLightDescription lamp;
    lamp.name = fmt::format("lamp {}", i);
    lamp.intensity = Rgb(float(kPiD * distance * distance / count));
    const double angle = 2 * kPiD * i / count;
    const Vec3d place =
        center + Vec3d(std::cos(angle), 1.0, std::sin(angle)) * (distance / std::sqrt(2.0));
    for (int c = 0; c < 3; ++c) lamp.to_world[3][c] = place[c];
    scene.lights.push_back(lamp);
  }
}

void line(const std::string& name, const std::vector<double>& seconds) {
  if (seconds.empty()) return;
  const Spread s = spread(seconds);
  fmt::print("{:<44}{:>9.3f} ms   {:.3f} to {:.3f}\n", name, 1e3 * s.median, 1e3 * s.minimum,
             1e3 * s.maximum);
}

void measure_cost(const Options& options, const BenchFrame& frame, const LightGroups& groups) {
  double sum = 0, squares = 0;
  std::vector<double> without;
  for (int i = 0; i < options.repetitions; ++i) {
    double cpu[2];
    for (const bool first : {true, false}) {
      const bool grouped = first == (i % 2 == 0);
      FrameSampling sampling;
      sampling.driver = options.frame.driver;
      sampling.spp = options.frame.spp.value_or(16);
      sampling.adaptive.budget = sampling.spp;
      if (grouped) sampling.light_groups = &groups;
      NullSink null_sink;
      cpu[grouped] = frame.run(options.threads, sampling, null_sink).cpu_s;
    }
    without.push_back(cpu[0]);
    const double ratio = std::log(cpu[1] / cpu[0]);
    sum += ratio;
    squares += ratio * ratio;
  }
  const double n = options.repetitions, mean = sum / n;
  const double error = n > 1 ? std::sqrt(std::max(0.0, squares / n - mean * mean) / (n - 1)) : 0.0;
  fmt::print("{}: {:.3f} s of processor time, with groups {:+.2f} % +- {:.2f} %, {} pairs\n",
             options.frame.driver, spread(without).median, 100 * mean, 100 * error,
             options.repetitions);
}

// Times relighting from an edit to R G B A. First come the weights, which say whether and how the
// groups can be mixed, and then the picture.
void measure_relight(const Options& options, const BenchFrame& frame, const LightGroups& groups) {
  FrameSampling sampling;
  sampling.driver = options.frame.driver;
  sampling.spp = sampling.adaptive.budget = 4;
  sampling.light_groups = &groups;
  std::vector<float> rgba(4 * frame.pixels(), 1.0f);
  std::vector<double> mixing, mixed, plain;
  NullSink null_sink;
  const auto on_picture = [&](const RenderJob& rendered) {
    if (!rendered.picture()) return;  // the driver keeps no picture
    fmt::print("{} light groups, film {:.1f} MiB\n", groups.size(),
               double(rendered.film_bytes()) / 1048576);
    for (int i = 0; i < 10 * options.repetitions; ++i) {
      SceneEdits edits;
      const LightGroup& group = groups.list()[size_t(i) % groups.list().size()];
      test::light(edits, group.kind, group.target.index).intensity = float(i % 3);
      const double start = wall_clock();
      const std::optional<LightMix> mix = groups.mix(edits);
      const double known = wall_clock();
      rendered.picture()->resolve(rgba, &*mix);
      const double shown = wall_clock();
      rendered.picture()->resolve(rgba);
      mixing.push_back(known - start);
      mixed.push_back(shown - known);
      plain.push_back(wall_clock() - shown);
    }
  };
  frame.run(options.threads, sampling, null_sink, {}, on_picture);
  line("from an edit to its weights", mixing);
  line("from weights to the picture", mixed);
  line("the picture without weights", plain);
}

}  // namespace

int run_light_groups_bench(int argc, char** argv) {
  Options options;
  options.frame.driver = "bisection";
  options.frame.filter = "box";
  CLI::App app("Times light groups", "light_groups_bench");
  add_frame_options(&app, options.frame);
  app.add_option("--lamps", options.lamps, "number of point lights to add to the scene")
      ->check(CLI::Range(0, 60));
  app.add_option("--threads", options.threads, "worker threads")->check(CLI::Range(1, 4096));
  app.add_option("--repetitions", options.repetitions, "repetitions of everything")
      ->check(CLI::Range(2, 10000));
  CLI11_PARSE(app, argc, argv);
  std::optional<LightGroups> groups;
  const BenchFrame frame(options.frame, {}, [&](SceneDescription& scene) {
    apply({}, scene);
    add_lamps(options.lamps, scene);
    groups.emplace(copy_without_geometry(scene));
  });
  measure_relight(options, frame, *groups);
  measure_cost(options, frame, *groups);
  return 0;
}

}  // namespace emberline::bench
