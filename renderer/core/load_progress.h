// Handles the progress reports, the cancellation, and the memory and time limits of a load.
//
// The caller creates one LoadProgress per load and passes it to load_gltf, build_scene or
// EditableScene. Loading code reports to this object; without a callback, a report costs one branch
// per image or mesh and nothing per texel or vertex. Progress reports do not affect the loaded
// scene.
#pragma once

#include <chrono>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>

#include "renderer/core/memory_budget.h"

namespace emberline {

// The caller cancelled the load. This is not an error and needs no message.
struct Cancelled : std::exception {
  const char* what() const noexcept override { return "cancelled"; }
};

// The stages of a load, in order.
enum class LoadStage : uint8_t { kReading, kMeshes, kImages, kEnvironment, kBvh, kLights };

// Limits of a load. `scene` is only for the message of a timeout.
struct LoadLimits {
  std::shared_ptr<MemoryBudget> memory = MemoryBudget::unlimited();
  std::optional<double> timeout_s;
  std::string scene;
  // If the textures exceed this size, they are kept in a file, and at most this many bytes of the
  // file are in memory. The environment map does not count towards this limit, because all of its
  // rows are read anyway.
  std::optional<uint64_t> texture_bytes = {};
};

class LoadProgress {
 public:
  // Receives the current step as text ("images 12 of 15") and the completed fraction. The fraction
  // never decreases, and is 1 once the scene is built. The callback is called at most a few hundred
  // times, from any loading thread but never from two at once. It must not throw.
  using Report = std::function<void(const std::string& stage, double fraction)>;

  // Any thread may request `stop`. The load then throws Cancelled within 40 ms, or within 250 ms at
  // the start of building a BVH of millions of triangles (tests/bench/results). The constructor
  // starts the timeout; a load that exceeds the timeout throws LimitError equally promptly.
  explicit LoadProgress(Report report, std::stop_token stop = {}, LoadLimits limits = {});
  LoadProgress(const LoadProgress&) = delete;
  LoadProgress& operator=(const LoadProgress&) = delete;

  // Returns an object without a callback, cancellation or limits.
  static LoadProgress& none();

  // ---- for loading code; thread-safe -----------------------------------------------------------

  bool watched() const { return watched_; }
  // Returns whether check() would throw.
  bool should_stop() const { return watched_ && (stop_.stop_requested() || timed_out()); }
  // Throws Cancelled if the load was cancelled, and LimitError after a timeout. begin() and
  // advance() also do this.
  void check() const {
    if (should_stop()) throw_stop_reason();
  }
  const std::shared_ptr<MemoryBudget>& budget() const { return limits_.memory; }
  const std::optional<uint64_t>& texture_bytes() const { return limits_.texture_bytes; }
  // Enters a stage that consists of `items` equal items. If a stage is repeated, the reported
  // fraction does not fall.
  void begin(LoadStage stage, uint64_t items = 0);
  void advance(uint64_t items = 1);
  // Reports that the fraction `share` of the next `items` items is done. Does not throw, so that
  // callbacks can use it.
  void report_partial(uint64_t items, double share) noexcept;
  void finish();

 private:
  using Clock = std::chrono::steady_clock;

  bool timed_out() const { return deadline_ && Clock::now() > *deadline_; }
  [[noreturn]] void throw_stop_reason() const;
  void report_stage_fraction(double share);  // requires mutex_

  const bool watched_;
  const Report report_;
  const std::stop_token stop_;
  const LoadLimits limits_;
  const std::optional<Clock::time_point> deadline_;
  std::mutex mutex_;
  LoadStage stage_ = LoadStage::kReading;
  uint64_t items_ = 0, done_ = 0;
  std::optional<LoadStage> reported_;
  double fraction_ = 0.0;  // last reported value
};

}  // namespace emberline
