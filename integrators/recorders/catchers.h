// Ends camera paths at holdouts and hidden catchers (SurfaceRoles), and records the light that
// shadow catchers receive with and without the scene's other objects (CatcherSample).
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
  // Samples lights at catchers after the paths have ended, with the random numbers of the catchers'
  // own light samples, so that catchers do not change the random numbers of paths.
  void ended(const LaneList&) {
    if (lanes_.empty() || b_.lights.empty()) return;
    for (const int lane : lanes_) catch_light(lane);
  }

 private:
  struct Catch {
    Ray ray;
    SurfaceHit hit;
    uint32_t slot;  // slot of the surface's random numbers
    float weight;   // transmittance of the panes in front of it
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
