// Owns a session as a window does: its thread sleeps until the session reports a change.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>

#include "renderer/core/errors.h"
#include "renderer/session/render_session.h"
#include "support/sanitized.h"

namespace emberline::test {

class SessionOwner {
 public:
  explicit SessionOwner(const ViewSettings& settings) : session(settings) {
    session.on_change([this] {
      {
        const std::lock_guard lock(mutex_);
        has_changed_ = true;
      }
      changed_.notify_one();
    });
  }
  ~SessionOwner() { session.on_change({}); }
  SessionOwner(const SessionOwner&) = delete;
  SessionOwner& operator=(const SessionOwner&) = delete;

  // Waits until `done()` returns true, and calls it after each change of the session. Returns false
  // if `done()` has not returned true after `seconds`.
  bool wait(double seconds, const std::function<bool()>& done) {
    using Clock = std::chrono::steady_clock;
    const auto end =
        Clock::now() + std::chrono::duration_cast<Clock::duration>(
                           std::chrono::duration<double>(kSanitizerSlowdown * seconds));
    while (!done()) {
      if (Clock::now() >= end) return false;
      std::unique_lock lock(mutex_);
      changed_.wait_until(lock, end, [&] { return has_changed_; });
      has_changed_ = false;
    }
    return true;
  }

  // Loads a scene and waits for its first picture. Throws RenderError if no picture appears.
  void open(const std::string& scene, const std::string& edits = {}) {
    session.open(scene, edits);
    wait(600, [&] { return session.load_status().state != LoadStatus::State::kLoading; });
    const LoadStatus status = session.load_status();
    if (status.state != LoadStatus::State::kReady) throw RenderError(status.error);
    if (!wait(60, [&] { return shows(session.edit()); })) {
      throw RenderError("no picture of " + scene + ": " + session.problem());
    }
  }
  // Returns whether the current picture covers the whole frame and includes this edit.
  bool shows(uint64_t edit) const {
    const auto picture = session.picture();
    return picture && picture->edit >= edit && picture->filled;
  }
  bool finished() const {
    const auto picture = session.picture();
    return picture && picture->edit == session.edit() && picture->finished;
  }

  RenderSession session;

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool has_changed_ = false;
};

}  // namespace emberline::test
