// What outlives a frame of `render`: threads, limits, what others are told, the scene.
#pragma once

#include <tbb/task_arena.h>

#include <memory>
#include <optional>
#include <vector>

#include "io/files/register.h"
#include "io/json/value.h"
#include "renderer/app/progress_file.h"
#include "renderer/app/stop_signal.h"
#include "renderer/core/errors.h"
#include "renderer/core/load_progress.h"
#include "renderer/description/framing.h"
#include "renderer/description/scene_edits.h"
#include "renderer/engine/open_scene.h"
#include "renderer/engine/process_usage.h"
#include "renderer/engine/render_clock.h"
#include "renderer/engine/run_limits.h"
#include "renderer/engine/worker_threads.h"
#include "renderer/output/checkpoint_head.h"
#include "renderer/output/render_options.h"
#include "renderer/output/report.h"

namespace emberline {

// The scene cannot be opened, which ends every frame of the run.
struct UnusableScene : EmberlineError {
  using EmberlineError::EmberlineError;
};

// How a frame has its scene.
struct ScenePose {
  std::optional<double> time;  // seconds; absent: at rest
  CameraDescription camera;    // without a turntable
  WorldBounds bounds;          // for one
};

// The scene of a frame that is read and not built.
struct ReadPose {
  ScenePose pose;
  std::optional<ReadScene> read;  // nothing where the run's scene is in that pose
};

// The scene in the pose of a frame, until the next frame's is built.
struct PosedScene {
  std::unique_ptr<OpenScene> open;
  ScenePose pose;
  size_t warnings = 0;  // when it was built: those of the scene, and of every frame

  CameraDescription camera_of(const FrameSettings& settings) const;
  void report(RenderReport& report) const;
};

// The scene of a run's frames: opened once, and posed for each frame where an animation moves it.
class RunScene {
 public:
  // `frames`: more than one will be asked for.
  explicit RunScene(bool frames) : frames_(frames) {}

  // Reads what the frame is made of, of a scene that is there only what an animation poses for
  // another time. Throws UnusableScene the first time.
  ReadPose load(const RenderOptions& options, const SceneBuildOptions& build,
                LoadProgress& progress);
  // Throws UnusableScene the first time.
  const PosedScene& build(ReadPose read, LoadProgress& progress);

  // The pose of the last frame that was built; null before the first.
  const PosedScene* posed() const { return posed_ ? &*posed_ : nullptr; }
  // The fingerprints of the loaded files. Throws what LoadedFiles does.
  const nlohmann::json& inputs(const RenderOptions& options, LoadProgress& progress);
  // Registers the files that the scene reads. Throws UsageError where one would be overwritten.
  void register_inputs(FileRegister& files) const;

 private:
  ReadScene open(const RenderOptions& options, const OpenOptions& asked, LoadProgress& progress);

  const bool frames_;
  std::optional<PosedScene> posed_;
  SceneEdits edits_;
  LoadedFiles loaded_;
  JsonValue inputs_;  // its fingerprints; null: not taken yet
  std::vector<NamedFile> files_;
};

// One frame uses it at a time.
class RenderRun {
 public:
  // Of one frame or a range. The options outlive it.
  explicit RenderRun(const RenderOptions& options);

  // Threads and the progress file, when the first frame's options have been looked at: what is
  // refused leaves no trace. Then for each frame.
  void begin();
  // From then on it is known which files the scene reads, and that none of them is written.
  void scene_is_read();
  // Once, when a frame begins to render.
  void save_settings();
  // From here on it is the next frame's time, and its warnings.
  void next_frame();
  void end(int exit_code);

  const std::optional<double> process_s = process_age_seconds();  // when it began
  const uint64_t memory_before = peak_rss_bytes();
  const LoadLimits limits;
  bool first = true;        // frame, whose time is also the run's setup
  Stopwatch wall;           // since the frame began
  double cpu_before_s = 0;  // processor time then; the first has all of the process
  std::optional<FramePlace> place;
  // The names of all frames of a range, until its scene is read.
  std::optional<FileRegister> names;
  std::optional<ProgressFile> progress_file;
  std::optional<WorkerThreads> workers;
  std::optional<tbb::task_arena> arena;
  // From the first frame that renders on: a signal lets the frame under way be written.
  std::optional<GracefulStop> graceful;
  RunScene scene;

 private:
  void begin_progress();

  const RenderOptions& options_;
  bool settings_saved_ = false;
};

}  // namespace emberline
