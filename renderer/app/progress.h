// Shows the progress and the time left: as a bar on a terminal, as plain lines in a pipe, and with
// --quiet not at all.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>

#include "renderer/app/progress_file.h"
#include "renderer/engine/render_plan.h"
#include "renderer/engine/stop_request.h"

namespace emberline {

// Shows the progress on its own thread. If a stop signal arrives or a time limit ends, this thread
// requests a stop. `limit` is the time limit of the frame. `allotted_s` is the time that this
// process has left (process_usage.h); when this time ends, the frame counts as stopped by the user.
// `label` precedes every line. If `file` is not null, it reports the same progress during the
// lifetime of this object.
class ProgressDisplay {
 public:
  ProgressDisplay(uint64_t samples_total, StopRequest& stop,
                  std::optional<TimeLimit> limit = std::nullopt,
                  std::optional<double> allotted_s = std::nullopt, std::string label = "",
                  ProgressFile* file = nullptr);
  ~ProgressDisplay();  // erases the bar

  // Thread-safe.
  void add(uint64_t samples) { done_.fetch_add(samples, std::memory_order_relaxed); }
  // For frames whose number of samples is unknown: adds a finished fraction of the whole work.
  void add_fraction(double delta) { fraction_.fetch_add(delta, std::memory_order_relaxed); }
  // For frames whose number of samples is unknown: the time that the frame is expected to take.
  void expect(double seconds) { expected_s_.store(seconds, std::memory_order_relaxed); }
  // Adds the work of an earlier run. This work counts as done, but does not affect the rate or the
  // time left.
  void add_resumed(uint64_t samples, double delta) {
    resumed_samples_.fetch_add(samples, std::memory_order_relaxed);
    resumed_fraction_.fetch_add(delta, std::memory_order_relaxed);
    add(samples);
    add_fraction(delta);
  }
  RenderProgress now() const;

 private:
  void run(const std::stop_token& thread_stop);
  void check_stop();
  void draw();
  // Returns the finished fraction of the whole, or 0 if it is unknown.
  double fraction(uint64_t done, double elapsed_s) const;
  std::string line(const RenderProgress& now) const;

  const uint64_t total_;
  std::atomic<uint64_t> done_{0};
  std::atomic<double> fraction_{0.0}, expected_s_{0.0};
  std::atomic<uint64_t> resumed_samples_{0};
  std::atomic<double> resumed_fraction_{0.0};
  StopRequest& stop_;
  const std::optional<TimeLimit> limit_;
  const std::optional<double> allotted_s_;
  const std::string label_;  // followed by blanks
  ProgressFile* const file_;
  const std::chrono::steady_clock::time_point start_;
  bool is_visible_;
  bool is_terminal_;
  int last_tenth_ = 0;
  double last_line_s_ = 0.0;  // seconds
  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::jthread thread_;
};

}  // namespace emberline
