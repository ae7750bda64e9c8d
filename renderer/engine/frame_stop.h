// Stops a frame when the caller asks for it or when its time is over.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>

#include "renderer/engine/render_plan.h"
#include "renderer/engine/stop_request.h"

namespace emberline {

// Combines the stop requests of the caller with a time limit. token() and cause() may be called on
// any thread.
class FrameStop {
 public:
  // A request through either token is a stop by the user.
  explicit FrameStop(const std::stop_token& stop, const std::stop_token& give_up = {})
      : by_caller_(stop, [this] { request_.request(PixelStop::kUser); }),
        by_abandonment_(give_up, [this] { request_.request(PixelStop::kUser); }) {}
  // Starts the clock of the time limit. Call this at most once.
  void begin(const std::optional<TimeLimit>& limit) {
    if (!limit) return;
    clock_ = std::jthread([this, limit = *limit](const std::stop_token& thread_stop) {
      std::unique_lock lock(mutex_);
      wake_.wait_for(lock, thread_stop, std::chrono::duration<double>(limit.seconds),
                     [] { return false; });
      if (!thread_stop.stop_requested()) request_.request(limit.cause);
    });
  }
  std::stop_token token() const { return request_.token(); }
  // Returns kNone if no stop has been requested.
  PixelStop cause() const { return request_.cause(); }

 private:
  StopRequest request_;
  std::stop_callback<std::function<void()>> by_caller_, by_abandonment_;
  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::jthread clock_;
};

}  // namespace emberline
