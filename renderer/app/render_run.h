// The state that the frames of a `render` share: threads, limits, progress file and scene.
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

// Thrown if the scene cannot be opened. In this case, every frame of the run would fail.
struct UnusableScene : EmberlineError {
  using EmberlineError::EmberlineError;
};

// The scene's state at the time of a frame.
struct ScenePose {
  std::optional<double> time;  // seconds; absent: the rest pose
  CameraDescription camera;    // before a turntable moves it
  WorldBounds bounds;          // for a turntable
};

// A frame's scene, read but not yet built.
struct ReadPose {
  ScenePose pose;
  std::optional<ReadScene> read;  // absent: the run's scene is already in that pose
};

// The built scene. It keeps one frame's pose until the next frame's pose is built.
struct PosedScene {
  std::unique_ptr<OpenScene> open;
  ScenePose pose;
  size_t warnings = 0;  // number of warnings before the scene was built; they apply to every frame

  CameraDescription camera_of(const FrameSettings& settings) const;
  void report(RenderReport& report) const;
};

// The scene of all frames of a run. It is opened once, then posed for each frame if it is animated.
class RunScene {
 public:
  // `frames` says whether more than one frame will be loaded.
  explicit RunScene(bool frames) : has_many_frames_(frames) {}

  // Reads the frame's scene. If the run's scene is already open, reads only what the animation
  // changes. Throws UnusableScene if the first call fails.
  ReadPose load(const RenderOptions& options, const SceneBuildOptions& build,
                LoadProgress& progress);
  // Throws UnusableScene if the first call fails.
  const PosedScene& build(ReadPose read, LoadProgress& progress);

  // The scene in the pose of the last built frame; null before the first.
  const PosedScene* posed() const { return posed_ ? &*posed_ : nullptr; }
  // Returns the fingerprints of the loaded files. Throws like LoadedFiles::fingerprints().
  const nlohmann::json& inputs(const RenderOptions& options, LoadProgress& progress);
  // Registers the files that the scene reads. Throws UsageError if an output would overwrite one of
  // them.
  void register_inputs(FileRegister& files) const;

 private:
  ReadScene open(const RenderOptions& options, const OpenOptions& open_options,
                 LoadProgress& progress);

  const bool has_many_frames_;
  std::optional<PosedScene> posed_;
  SceneEdits edits_;
  LoadedFiles loaded_;
  JsonValue inputs_;  // fingerprints of the loaded files; null: not computed yet
  std::vector<NamedFile> files_;
};

// Only one frame at a time may use this object.
class RenderRun {
 public:
  // Runs one frame or a range. `options` must outlive it.
  explicit RenderRun(const RenderOptions& options);

  // Each frame calls this after it has checked its options, so that invalid options leave no files
  // behind. The first call starts the threads and the progress file.
  void begin();
  // Call after the scene's files are registered, so that the progress file cannot overwrite one of
  // them.
  void on_scene_read();
  // Saves the settings once, when the first frame begins to render.
  void save_settings();
  // Restarts the clocks and forgets the warnings of the last frame.
  void next_frame();
  void end(int exit_code);

  const std::optional<double> process_s = process_age_seconds();  // age of the process
  const uint64_t memory_before = peak_rss_bytes();
  const LoadLimits limits;
  bool first = true;        // the first frame's times include the run's setup
  Stopwatch wall;           // since the frame began
  double cpu_before_s = 0;  // processor time used before this frame; 0 for the first frame
  std::optional<FramePosition> frame_position;
  // The file names of all frames of a range. Absent once the scene has been read.
  std::optional<FileRegister> names;
  std::optional<ProgressFile> progress_file;
  std::optional<WorkerThreads> workers;
  std::optional<tbb::task_arena> arena;
  // Set when the first frame starts to render. From then on, the current frame is still written
  // after a first stop signal.
  std::optional<GracefulStop> graceful;
  RunScene scene;

 private:
  void begin_progress();

  const RenderOptions& options_;
  bool settings_saved_ = false;
};

}  // namespace emberline
