// Clamps indirect light (IntegratorSettings::clamp_indirect) and records the light that this
// removes.
#pragma once

#include "integrators/recorders/hooks.h"
#include "integrators/recorders/light_groups.h"
#include "renderer/film/clamped_light.h"

namespace emberline {

class ClampRecorder : public Recorder {
 public:
  explicit ClampRecorder(PathBatch& batch) : Recorder(batch) {}
  static bool is_enabled(const SampleBatch& batch) { return batch.clamped; }

  void begin(int lane) {
    if (clamped_light_) removed_light_.emplace(lane) = Rgb(0.0f);
  }
  Rgb emitted(int lane, const Rgb& light) {
    if (!clamped_light_ || b_.paths[lane].bounces != Bounces::kMore) return light;
    return clamp(lane, groups_.of_surface(lane), light);
  }
  Rgb environment(int lane, const Rgb&, const Rgb& light) {
    if (!clamped_light_ || b_.paths[lane].bounces != Bounces::kMore) return light;
    return clamp(lane, groups_.of_environment(), light);
  }
  // The vertex that the light sample starts from counts as one more bounce.
  Rgb connected(int lane, const Rgb& light) {
    if (!clamped_light_ || b_.paths[lane].bounces == Bounces::kNone) return light;
    return clamp(lane, groups_.of_connection(lane), light);
  }
  void paths_ended(const LaneList& hit) {
    if (!clamped_light_) return;
    for (const int lane : hit) b_.values[size_t(lane)].clamped = removed_light_[lane];
  }

 private:
  // Leaves non-finite light unchanged, so that the film finds and counts it.
  Rgb clamp(int lane, uint32_t group, const Rgb& light) {
    const Rgb& throughput = b_.paths[lane].throughput;
    const Rgb contribution = throughput * light;
    const float brightest = max_component(contribution);
    const float limit = b_.settings.clamp_indirect;
    if (!(brightest > limit) || !is_finite(contribution)) return light;
    const Rgb clamped = light * (limit / brightest);
    const Rgb removed = throughput * (light - clamped);
    removed_light_[lane] += removed;
    clamped_light_->add_removed(group, removed);
    return clamped;
  }

  BatchLightGroups groups_{b_};
  ClampedLight* const clamped_light_ = b_.batch.clamped;  // null if nothing is clamped
  LaneArray<Rgb> removed_light_;                          // by lane
};

}  // namespace emberline
