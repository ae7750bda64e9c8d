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
  static bool is_enabled(const SampleBatch& batch) {
    return batch.roles || !batch.catcher_samples.empty();
  }

  void camera_missed(const LaneList& missed) {
    if (!roles_ || catcher_samples_.empty()) return;
    for (const int lane : missed) catcher_samples_[size_t(lane)].background = 1.0f;
  }
  void surfaces_hit() {
    if (roles_) b_.alive.filter([this](int lane) { return continues_path(lane); });
  }
  void missed(int lane) {
    if (!catcher_samples_.empty() && b_.paths[lane].events == 0) {
      catcher_samples_[size_t(lane)].background = luminance(b_.paths[lane].throughput);
    }
  }
  // Samples lights at catchers. Runs after the paths have ended, so that catchers do not change the
  // random numbers of paths. Uses the same random numbers as the path's light sample at the
  // catcher.
  void paths_ended(const LaneList&) {
    if (lanes_.empty() || b_.lights.empty()) return;
    for (const int lane : lanes_) sample_catcher_light(lane);
  }

 private:
  struct CatcherHit {
    Ray ray;
    SurfaceHit hit;
    uint32_t slot;  // slot of the surface's random numbers
    float weight;   // transmittance of the walls in front of the catcher
  };
  bool continues_path(int lane);
  void sample_catcher_light(int lane);
  void connect(int lane, const SurfaceInteraction& surface, const LightSample& light, float weight);

  const SurfaceRoles* const roles_ = b_.batch.roles;  // null if there are none
  // If empty, light on catchers is not recorded.
  const std::span<CatcherSample> catcher_samples_ = b_.batch.catcher_samples;
  LaneList lanes_;
  LaneArray<CatcherHit> catcher_hits_;
};

}  // namespace emberline
