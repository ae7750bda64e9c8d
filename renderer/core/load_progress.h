// How far loading has come, for whoever waits for it, and how to call it off.
//
// Whoever waits makes a LoadProgress and hands it to load_gltf, build_scene or EditableScene, one
// load each. Those that load say where they are; where nobody looks, that is a branch per image or
// mesh and nothing at all per texel or vertex. What is loaded is the same with and without.
#pragma once

#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>

namespace emberline {

// The load was called off, by whoever asked for it: no error, and nothing to tell a user about.
struct Cancelled : std::exception {
  const char* what() const noexcept override { return "cancelled"; }
};

// In the order in which they come.
enum class LoadStage : uint8_t { kReading, kMeshes, kImages, kEnvironment, kBvh, kLights };

class LoadProgress {
 public:
  // What is being done, for people ("images 12 of 15"), and the share of the whole that is done:
  // in [0, 1], never less than before, 1 once the scene is built. Called some hundred times at
  // most, from the threads that load, one call at a time; must not throw.
  using Report = std::function<void(const std::string& stage, double fraction)>;

  // `stop` may be asked from any thread. The load then ends with Cancelled: within 40 ms, but
  // up to 250 at the beginning of a BVH of millions of triangles (renderer/scene/README.md).
  explicit LoadProgress(Report report, std::stop_token stop = {});
  LoadProgress(const LoadProgress&) = delete;
  LoadProgress& operator=(const LoadProgress&) = delete;

  // Nobody looks, nobody stops.
  static LoadProgress& unwatched();

  // ---- for those that load; thread-safe --------------------------------------------------------

  bool watched() const { return watched_; }
  bool cancelled() const { return watched_ && stop_.stop_requested(); }
  // Throws Cancelled if the load was called off, as do begin and advance.
  void check() const {
    if (cancelled()) throw Cancelled();
  }
  // Enters a stage of so many equal items; a stage that is gone through twice does not go back.
  void begin(LoadStage stage, uint64_t items = 0);
  void advance(uint64_t items = 1);
  // Of the next so many items this share is done. Does not throw: for callbacks.
  void partly(uint64_t items, double share) noexcept;
  void finish();

 private:
  void report_share(double share);  // holds mutex_

  const bool watched_;
  const Report report_;
  const std::stop_token stop_;
  std::mutex mutex_;
  LoadStage stage_ = LoadStage::kReading;
  uint64_t items_ = 0, done_ = 0;
  std::optional<LoadStage> reported_;
  double fraction_ = 0.0;  // as last reported
};

}  // namespace emberline
