// Ends camera paths at holdouts and hidden catchers (SurfaceRoles), and records what shadow
// catchers receive of the lights, with the scene's other objects and without (CatcherSample).
#pragma once

#include <span>

#include "integrators/recorders/hooks.h"
#include "renderer/scene/surface_roles.h"

namespace emberline {

class CatcherRecorder : public Recorder {
 public:
  explicit CatcherRecorder(PathBatch& batch) : Recorder(batch) {}
  static bool wanted(const SampleBatch& batch) {
    return batch.roles || !batch.catcher_samples.empty();
  }

  void camera_missed(const LaneList& missed) {
    if (!roles_ || caught_.empty()) return;
    for (const int lane : missed) caught_[size_t(lane)].background = 1.0f;
  }
  void met_surfaces() {
    if (roles_) b_.alive.filter([this](int lane) { return goes_on(lane); });
  }
  void missed(int lane) {
    if (!caught_.empty() && b_.paths[lane].events == 0) {
      caught_[size_t(lane)].background = luminance(b_.paths[lane].throughput);
    }
  }
  // Samples the lights at catchers when the paths are done, with the numbers of the catchers' own
  // light samples, so that no path has other numbers because of catchers.
  void ended(const LaneList&) {
    if (lanes_.empty() || b_.lights.empty()) return;
    for (const int lane : lanes_) catch_light(lane);
  }

 private:
  struct Catch {
    Ray ray;
    SurfaceHit hit;
    uint32_t slot;  // of the surface's numbers
    float weight;   // what panes in front of it let through
  };
  bool goes_on(int lane);
  void catch_light(int lane);
  void connect(int lane, const SurfaceInteraction& surface, const LightSample& light, float weight);

  const SurfaceRoles* const roles_ = b_.batch.roles;  // null: none
  // Empty: light on catchers is not recorded.
  const std::span<CatcherSample> caught_ = b_.batch.catcher_samples;
  LaneList lanes_;
  LaneArray<Catch> catches_;
};

}  // namespace emberline
