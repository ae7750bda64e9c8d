// Times edits of a built scene, and measures the cost of an editable scene. This is not a test.
// tests/bench/results has the figures.
//
//   edits_bench SCENE [--env FILE] [--look-from X,Y,Z --look-at X,Y,Z] [--size WxH] [--spp N]
//       [--repetitions N]
//
// Applies each edit to every light or material of its kind, and undoes it. Times both steps.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <functional>
#include <thread>

#include "bench/bench_frame.h"
#include "bench/frame_benches.h"
#include "renderer/core/errors.h"
#include "renderer/engine/frame_scene.h"
#include "renderer/scene/editable_scene.h"
#include "support/edits.h"
#include "support/load_scene.h"

namespace emberline::bench {
namespace {

using test::light;
using test::material;

void line(const std::string& name, const std::vector<double>& seconds) {
  if (seconds.empty()) return;
  const Spread s = spread(seconds);
  fmt::print("{:<28}{:>10.3f} ms   {:.3f} to {:.3f}, {} times\n", name, 1e3 * s.median,
             1e3 * s.minimum, 1e3 * s.maximum, seconds.size());
}

// Applies `edit` to each of `count` objects and undoes it. Returns the seconds of each step.
std::vector<double> time_edits(EditableScene& scene, size_t count, int repetitions,
                               const std::function<void(SceneEdits&, int)>& edit) {
  std::vector<double> seconds;
  for (int r = 0; r < repetitions; ++r) {
    for (size_t i = 0; i < count; ++i) {
      SceneEdits edits;
      edit(edits, int(i));
      for (const SceneEdits& next : {edits, SceneEdits{}}) {
        const double start = wall_clock();
        scene.set(next);
        seconds.push_back(wall_clock() - start);
      }
    }
  }
  return seconds;
}

void time_all_edits(const RenderOptions& options, int repetitions) {
  const double start = wall_clock();
  const SceneDescription description = test::load_scene(options);
  fmt::print("{:<28}{:>10.3f} ms\n", "load", 1e3 * (wall_clock() - start));
  std::vector<double> full, editable;
  for (int r = 0; r < repetitions; ++r) {
    SceneDescription a = description, b = description;
    double begin = wall_clock();
    build_scene(std::move(a), {});
    full.push_back(wall_clock() - begin);
    begin = wall_clock();
    const EditableScene scene(std::move(b));
    editable.push_back(wall_clock() - begin);
  }
  line("full build", full);
  line("full build, editable", editable);

  EditableScene scene(description);
  const size_t materials = scene.original().materials.size();
  const uint32_t builds = scene.scene().bvh_builds();
  const auto time = [&](const char* name, size_t count, auto edit) {
    line(name, time_edits(scene, count, repetitions, edit));
  };
  time("camera", 1, [](SceneEdits& e, int) { e.camera.fov_y_degrees = 20.0; });
  time("punctual light", scene.original().lights.size(),
       [](SceneEdits& e, int i) { light(e, EditedLight::kPunctual, i).intensity = 2.0f; });
  const size_t environments = scene.original().environment ? 1 : 0;
  time("environment, rotation", environments,
       [](SceneEdits& e, int) { e.environment.rotation_degrees = 50.0f; });
  time("environment, colour", environments, [](SceneEdits& e, int) {
    light(e, EditedLight::kEnvironment, -1).color = Rgb(1.0f, 0.5f, 0.2f);
  });
  time("environment, off and on", environments,
       [](SceneEdits& e, int) { light(e, EditedLight::kEnvironment, -1).on = false; });
  time("emissive material, factor", materials,
       [](SceneEdits& e, int i) { light(e, EditedLight::kMaterial, i).intensity = 2.0f; });
  time("base colour", materials,
       [](SceneEdits& e, int i) { material(e, i).base_color = Rgb(0.5f); });
  time("roughness", materials, [](SceneEdits& e, int i) { material(e, i).roughness = 0.3f; });
  time("normal strength", materials,
       [](SceneEdits& e, int i) { material(e, i).normal_scale = 0.0f; });
  time("transmission", materials, [](SceneEdits& e, int i) { material(e, i).transmission = 0.5f; });
  time("emission on and off", materials,
       [](SceneEdits& e, int i) { material(e, i).emission = Rgb(3.0f); });
  fmt::print("BVH builds: {} by the build, {} by the edits\n", builds,
             scene.scene().bvh_builds() - builds);
}

// Renders the same frame of an editable scene and of a fixed one in turn.
void time_frames(const RenderOptions& options, int repetitions) {
  SceneBuildOptions build;
  build.editable = true;
  const BenchFrame plain(options), editable(options, build);
  const int threads = int(std::max(1u, std::thread::hardware_concurrency()));
  std::vector<double> seconds, ratios;
  for (int r = 0; r < repetitions; ++r) {
    const double a = plain.run(threads, *options.spp).cpu_s;
    const double b = editable.run(threads, *options.spp).cpu_s;
    seconds.push_back(a);
    ratios.push_back(b / a);
  }
  const Spread s = spread(ratios);
  fmt::print("CPU time of a frame ({:.2f} s), editable against not: {:.3f}   {:.3f} to {:.3f}\n",
             spread(seconds).median, s.median, s.minimum, s.maximum);
}

}  // namespace

int run_edits_bench(int argc, char** argv) {
  CLI::App app("Times edits of a scene", "edits_bench");
  RenderOptions options;
  options.spp = 8;
  int repetitions = 5;
  add_frame_options(&app, options);
  app.add_option("--repetitions", repetitions, "repetitions of everything [5]");
  CLI11_PARSE(app, argc, argv);
  time_all_edits(options, repetitions);
  time_frames(options, repetitions);
  return 0;
}

}  // namespace emberline::bench
