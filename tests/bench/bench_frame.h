// A frame that is set up once and rendered and timed repeatedly, for whole-frame benchmarks.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bench/clocks.h"
#include "renderer/drivers/adaptive/round_planner.h"
#include "renderer/drivers/driver_table.h"
#include "renderer/engine/render_job.h"
#include "renderer/output/render_options.h"
#include "renderer/scene/build_scene.h"
#include "renderer/scene/camera.h"
#include "renderer/scene/scene.h"

namespace CLI {
class App;
}  // namespace CLI

namespace emberline::bench {

// Runs a benchmark's main function. Reports errors in the scene or the options, and returns the
// exit code of `emberline`.
int run_program(const char* name, int (*run)(int argc, char** argv), int argc, char** argv);

// Adds the options of `emberline render` that choose scene, view, light and sampling.
void add_frame_options(CLI::App* app, RenderOptions& options);

struct FrameRun {
  double wall_s = 0;
  double returned = 0;        // wall_clock() at the end of wall_s
  double cpu_s = 0;           // of the whole process
  double first_sample_s = 0;  // until the first progress report: one worker's first 2048 samples
  RenderCounters counters;
  std::optional<double> error_estimate;  // the driver's own
};

// How a frame is sampled, apart from the sampler.
struct FrameSampling {
  std::string driver = "bucket";
  uint32_t spp = 64;
  uint32_t seed = 0;
  StreamCount streams = StreamCount::kOne;
  AdaptiveSettings adaptive;
  AovSet aovs;
  const LightGroups* light_groups = nullptr;
};

class BenchFrame {
 public:
  // Loads and builds the scene, and throws the command's errors. `change`, if given, edits the
  // description in between.
  explicit BenchFrame(const RenderOptions& options, const SceneBuildOptions& build = {},
                      const std::function<void(SceneDescription&)>& change = {});

  // Renders without a file or display.
  FrameRun run(int threads, uint32_t spp) const;
  // Renders into `sink`. The times cover RenderJob::render(), not deliver(). `on_picture`, if
  // given, is called with the finished job.
  FrameRun run(int threads, const FrameSampling& sampling, RenderSink& sink,
               const std::stop_token& stop = {},
               const std::function<void(const RenderJob&)>& on_picture = {}) const;

  double load_s = 0, build_s = 0;
  const Scene& scene() const { return *scene_; }
  int width() const { return options_.width; }
  int height() const { return options_.height; }
  uint64_t pixels() const { return uint64_t(options_.width) * uint64_t(options_.height); }

 private:
  RenderOptions options_;
  std::unique_ptr<Scene> scene_;
  Camera camera_;
};

}  // namespace emberline::bench
