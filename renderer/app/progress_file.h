// --progress-file: how far a run is, for whoever looks from another machine.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

namespace emberline {

// How far a frame is.
struct RenderProgress {
  double done = 0;  // of the whole, from 0 to 1; 0 where that is not known
  uint64_t samples = 0;
  double elapsed_s = 0;
  std::optional<double> left_s;  // absent: nothing tells
};

// A frame among those of a range.
struct FramePlace {
  int frame = 0;                // its number
  size_t index = 1, count = 1;  // it is the index-th of so many

  std::string text() const;  // "frame 112 (12 of 100)"
};

// Whether there is a regular file of that name that no ProgressFile has written.
bool is_other_file(const std::string& path);

// A JSON file, written every two seconds by a thread of its own, so that a slow disk keeps nobody:
// {"state", "done", "samples", "elapsed_s", "left_s", "host", "pid", "written"}; `state` is
// running, done, stopped or failed, `written` the time by this machine's clock, in UTC. A file that
// cannot be written is one warning. Of a range, all of them are the range's, and "frame" has
// {"number", "index", "count", "done"} of the one under way; frames that were skipped tell nothing
// of the time that is left.
class ProgressFile {
 public:
  explicit ProgressFile(const std::string& path);
  // Without finish() the run has failed.
  ~ProgressFile();

  // Asks `source` from now on, on the thread of its own; null: what it said last holds.
  void watch(std::function<RenderProgress()> source);
  // What is told from now on is about this frame of a range.
  void begin_frame(const FramePlace& place);
  // Writes the last state: an exit code of ours.
  void finish(int exit_code);

 private:
  void run();
  std::string text();  // holds mutex_
  RenderProgress whole() const;
  void write(const std::string& text);

  const std::string path_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::function<RenderProgress()> source_;
  RenderProgress last_;     // of the frame
  RenderProgress earlier_;  // of the range's frames before it: `done` counts those that rendered
  std::optional<FramePlace> place_;
  const char* state_ = "running";
  bool ending_ = false;
  bool warned_ = false;  // the thread's alone
  std::thread thread_;
};

}  // namespace emberline
