#include "bench/bench_frame.h"

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <CLI/CLI.hpp>
#include <array>
#include <atomic>

#include "renderer/core/errors.h"
#include "renderer/core/names.h"
#include "renderer/core/option_values.h"
#include "renderer/engine/frame_scene.h"
#include "renderer/engine/render_job.h"
#include "renderer/engine/render_plan.h"
#include "renderer/engine/setting_table.h"
#include "renderer/film/film.h"
#include "renderer/scene/build_scene.h"
#include "support/load_scene.h"

namespace emberline::bench {
namespace {

// Drops the tiles and notes when the first samples were done.
class NullSink final : public RenderSink {
 public:
  void tile_finished(const FilmTile& /*tile*/) override {}
  void samples_finished(uint64_t /*count*/) override {
    if (!begun_.load(std::memory_order_relaxed) && !begun_.exchange(true)) first_ = wall_clock();
  }
  double first() const { return first_; }

 private:
  std::atomic<bool> begun_{false};
  double first_ = 0;
};

void add_point(CLI::App* app, const char* name, std::optional<Vec3d>& target, const char* help) {
  app->add_option_function<std::string>(
         name,
         [&target, name](const std::string& text) {
           std::array<double, 3> v;
           if (!parse_numbers(text, ',', v)) throw CLI::ValidationError(name, "needs X,Y,Z");
           target = Vec3d(v[0], v[1], v[2]);
         },
         help)
      ->type_name("X,Y,Z");
}

}  // namespace

void add_frame_options(CLI::App* app, RenderOptions& o) {
  app->add_option("scene", o.scene, "a .gltf or .glb file")->required();
  app->add_option("--camera", o.camera, "camera of the file, by name or index");
  add_point(app, "--look-from", o.look_from, "camera position instead");
  add_point(app, "--look-at", o.look_at, "towards this point");
  app->add_option("--fov-y", o.fov_y, "degrees")->check(CLI::Range(0.05, 179.9));
  app->add_option("--env", o.environment, "latitude-longitude environment map");
  app->add_option("--env-strength", o.environment_strength, "multiplies it")
      ->check(CLI::Range(0.0f, 1e9f));
  app->add_option_function<std::string>(
         "--size",
         [&o](const std::string& text) {
           std::array<int, 2> v;
           if (!parse_numbers(text, 'x', v) || v[0] < 1 || v[1] < 1) {
             throw CLI::ValidationError("--size", "needs WxH");
           }
           o.width = v[0];
           o.height = v[1];
         },
         "frame in pixels")
      ->type_name("WxH");
  app->add_option("--spp", o.spp, "samples per pixel")->check(CLI::Range(1u, kMaxSamples));
  app->add_option("--max-depth", o.max_depth, "scattering events")->check(CLI::Range(0, 100000));
  app->add_option("--integrator", o.integrator, "integrator");
  app->add_option("--sampler", o.sampler, "sampler");
  app->add_option("--filter", o.filter, "pixel filter");
  app->add_option("--driver", o.driver, "frame driver");
  for (const char* name : {"bisection-axis", "reconstruction", "f-stop", "focus-distance",
                           "animation", "time", "fps", "shutter"}) {
    const Setting& setting = find_named(setting_table(), "--settings", "setting", name);
    app->add_option_function<std::string>(
        "--" + setting.name, [&o, &setting](const std::string& text) { setting.read(o, text); },
        setting.help.full);
  }
  app->add_option("--bucket-size", o.bucket_size, "in pixels")->check(CLI::Range(1, 4096));
  app->add_option("--seed", o.seed, "different seeds give different noise")
      ->check(CLI::Range(0u, 0xffffffffu));
}

BenchFrame::BenchFrame(const RenderOptions& options, const SceneBuildOptions& build,
                       const std::function<void(SceneDescription&)>& change)
    : options_(options) {
  const double start = wall_clock();
  SceneDescription description = test::load_scene(options);
  const CameraDescription view = choose_camera(options, description);
  if (change) change(description);
  const double loaded = wall_clock();
  scene_ = build_scene(std::move(description), build);
  camera_ = Camera(view, options.width, options.height, scene_->origin(), scene_->scale());
  load_s = loaded - start;
  build_s = wall_clock() - loaded;
}

FrameRun BenchFrame::run(int threads, uint32_t spp) const {
  NullSink sink;
  FrameSampling sampling;
  sampling.driver = options_.driver;
  sampling.spp = spp;
  sampling.seed = options_.seed;
  const double start = wall_clock();
  FrameRun result = run(threads, sampling, sink);
  result.first_sample_s = sink.first() - start;
  return result;
}

FrameRun BenchFrame::run(int threads, const FrameSampling& s, RenderSink& sink,
                         const std::stop_token& stop,
                         const std::function<void(const RenderJob&)>& on_picture) const {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, size_t(threads));
  FrameSettings settings = options_;
  settings.driver = "bucket";  // avoids the checks of other drivers
  settings.spp = s.spp;
  settings.seed = s.seed;
  settings.streams = int(s.streams);
  RenderPlan plan(settings);
  plan.aovs = s.aovs;
  plan.is_uniform = s.driver != "adaptive";
  plan.driver_settings.adaptive = s.adaptive;
  const Frame frame = plan.frame(*scene_, camera_, {.light_groups = s.light_groups});
  RenderJob job(frame, driver_factory(s.driver, plan.driver_settings));
  tbb::task_arena arena(threads);
  FrameRun run;
  const double wall = wall_clock(), cpu = process_cpu();
  arena.execute([&] { run.counters = job.render(sink, stop).counters; });
  run.returned = wall_clock();
  run.wall_s = run.returned - wall;
  run.cpu_s = process_cpu() - cpu;
  arena.execute([&] { job.deliver(sink); });
  run.error_estimate = job.error_estimate();
  if (on_picture) arena.execute([&] { on_picture(job); });
  return run;
}

int run_program(const char* name, int (*run)(int argc, char** argv), int argc, char** argv) try {
  return run(argc, argv);
} catch (const EmberlineError& error) {
  fmt::print(stderr, "{}: {}\n", name, error.what());
  return error.exit_code();
} catch (const std::exception& error) {
  fmt::print(stderr, "{}: {}\n", name, error.what());
  return 1;
}

}  // namespace emberline::bench
