// How far loading has come, for whoever waits for it, how to call it off, and what it may take of
// memory and time.
//
// Whoever waits makes a LoadProgress and hands it to load_gltf, build_scene or EditableScene, one
// load each. Those that load say where they are; where nobody looks, that is a branch per image or
// mesh and nothing at all per texel or vertex. What is loaded is the same with and without.
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

// The load was called off, by whoever asked for it: no error, and nothing to tell a user about.
struct Cancelled : std::exception {
  const char* what() const noexcept override { return "cancelled"; }
};

// In the order in which they come.
enum class LoadStage : uint8_t { kReading, kMeshes, kImages, kEnvironment, kBvh, kLights };

// What a load may take. `scene` is named in the error of one that takes longer.
struct LoadLimits {
  std::shared_ptr<MemoryBudget> memory = MemoryBudget::unlimited();
  std::optional<double> timeout_s;
  std::string scene;
  // A scene's textures that take more are held in a file, and of that so much in memory. Not the
  // environment, whose every row is read anyway.
  std::optional<uint64_t> texture_bytes = {};
};

class LoadProgress {
 public:
  // What is being done, for people ("images 12 of 15"), and the share of the whole that is done:
  // in [0, 1], never less than before, 1 once the scene is built. Called some hundred times at
  // most, from the threads that load, one call at a time; must not throw.
  using Report = std::function<void(const std::string& stage, double fraction)>;

  // `stop` may be asked from any thread. The load then ends with Cancelled: within 40 ms, but
  // up to 250 at the beginning of a BVH of millions of triangles.
  // The time of the limits runs from here on; the load that takes longer ends with InputError, as
  // soon as with Cancelled.
  explicit LoadProgress(Report report, std::stop_token stop = {}, LoadLimits limits = {});
  LoadProgress(const LoadProgress&) = delete;
  LoadProgress& operator=(const LoadProgress&) = delete;

  // Nobody looks, nobody stops, and nothing is too much.
  static LoadProgress& unwatched();

  // ---- for those that load; thread-safe --------------------------------------------------------

  bool watched() const { return watched_; }
  // Whether check() would throw.
  bool ends() const { return watched_ && (stop_.stop_requested() || late()); }
  // Throws Cancelled if the load was called off, InputError if it takes too long, as do begin and
  // advance.
  void check() const {
    if (ends()) throw_end();
  }
  const std::shared_ptr<MemoryBudget>& budget() const { return limits_.memory; }
  const std::optional<uint64_t>& texture_bytes() const { return limits_.texture_bytes; }
  // Enters a stage of so many equal items; a stage that is gone through twice does not go back.
  void begin(LoadStage stage, uint64_t items = 0);
  void advance(uint64_t items = 1);
  // Of the next so many items this share is done. Does not throw: for callbacks.
  void partly(uint64_t items, double share) noexcept;
  void finish();

 private:
  using Clock = std::chrono::steady_clock;

  bool late() const { return deadline_ && Clock::now() > *deadline_; }
  [[noreturn]] void throw_end() const;
  void report_share(double share);  // holds mutex_

  const bool watched_;
  const Report report_;
  const std::stop_token stop_;
  const LoadLimits limits_;
  const std::optional<Clock::time_point> deadline_;
  std::mutex mutex_;
  LoadStage stage_ = LoadStage::kReading;
  uint64_t items_ = 0, done_ = 0;
  std::optional<LoadStage> reported_;
  double fraction_ = 0.0;  // as last reported
};

}  // namespace emberline
