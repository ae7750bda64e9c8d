// --progress-file: reports a run's progress to other processes and machines.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

namespace emberline {

struct RenderProgress {
  double done = 0;  // fraction of the whole, 0 to 1; 0 if unknown
  uint64_t samples = 0;
  double elapsed_s = 0;
  std::optional<double> left_s;  // absent: unknown
};

// The position of a frame in a range.
struct FramePosition {
  int frame = 0;                // its number
  size_t index = 1, count = 1;  // `index` starts at 1

  std::string text() const;  // "frame 112 (12 of 100)"
};

// Whether `path` is a regular file that was not written by a ProgressFile.
bool is_foreign_file(const std::string& path);

// Writes a JSON file every two seconds: {"state", "done", "samples", "elapsed_s", "left_s", "host",
// "pid", "written"}. Uses its own thread, so that a slow disk delays nothing else. `state` is
// running, done, stopped or failed; `written` is this machine's time in UTC. Only the first failed
// write causes a warning. For a range, the values cover the whole range, and "frame" describes the
// current frame: {"number", "index", "count", "done"}. The time left is computed from rendered
// frames only, not from skipped ones.
class ProgressFile {
 public:
  explicit ProgressFile(const std::string& path);
  // Sets the state to "failed" if finish() was not called.
  ~ProgressFile();

  // From now on, this object's thread calls `source` to get the progress. If `source` is null, the
  // last values remain.
  void set_source(std::function<RenderProgress()> source);
  // From now on, reports the progress of this frame of a range.
  void begin_frame(const FramePosition& frame_position);
  // Writes the final state for an exit code of `emberline`.
  void finish(int exit_code);

 private:
  void run();
  std::string text();  // mutex_ must be held
  RenderProgress range_progress() const;
  void write(const std::string& text);

  const std::string path_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::function<RenderProgress()> source_;
  RenderProgress current_;         // progress of the current frame
  RenderProgress earlier_frames_;  // sums over earlier frames; `done` counts the rendered ones
  std::optional<FramePosition> position_;
  const char* state_ = "running";
  bool is_finishing_ = false;
  bool warned_ = false;  // used only by thread_
  std::thread thread_;
};

}  // namespace emberline
