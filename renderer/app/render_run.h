// What outlives a frame of `render`: threads, limits, what others are told, the scene.
#pragma once

#include <tbb/task_arena.h>

#include <optional>

#include "io/files/register.h"
#include "renderer/app/progress_file.h"
#include "renderer/app/run_scene.h"
#include "renderer/app/stop_signal.h"
#include "renderer/engine/process_usage.h"
#include "renderer/engine/render_clock.h"
#include "renderer/engine/run_limits.h"
#include "renderer/engine/worker_threads.h"
#include "renderer/output/render_options.h"

namespace emberline {

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
