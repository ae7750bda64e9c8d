// All recorders of the path loop. Each recorder is on if the batch asks for its output.
#pragma once

#include "integrators/recorders/catchers.h"
#include "integrators/recorders/clamp.h"
#include "integrators/recorders/features.h"
#include "integrators/recorders/first_hit.h"
#include "integrators/recorders/light_groups.h"
#include "integrators/recorders/occlusion.h"
#include "integrators/recorders/path_layers.h"
#include "integrators/recorders/specular_motion.h"

namespace emberline {

// Calls each hook (hooks.h) of several recorders, in order.
template <class... Recorders>
class RecorderList : Recorders... {
 public:
  explicit RecorderList(PathBatch& batch) : Recorders(batch)... {}
  static bool is_enabled(const SampleBatch& batch) { return (Recorders::is_enabled(batch) || ...); }

  void begin(int lane) { (Recorders::begin(lane), ...); }
  void camera_missed(const LaneList& missed) { (Recorders::camera_missed(missed), ...); }
  void background(int lane, const Rgb& radiance) { (Recorders::background(lane, radiance), ...); }
  void surfaces_hit() { (Recorders::surfaces_hit(), ...); }
  void shaded(int lane) { (Recorders::shaded(lane), ...); }
  Rgb emitted(int lane, Rgb light) {
    ((light = Recorders::emitted(lane, light)), ...);
    return light;
  }
  Rgb environment(int lane, const Rgb& radiance, Rgb light) {
    ((light = Recorders::environment(lane, radiance, light)), ...);
    return light;
  }
  Rgb connected(int lane, Rgb light) {
    ((light = Recorders::connected(lane, light)), ...);
    return light;
  }
  void scattered(int lane, const BsdfSample& next) { (Recorders::scattered(lane, next), ...); }
  void missed(int lane) { (Recorders::missed(lane), ...); }
  void paths_ended(const LaneList& hit) { (Recorders::paths_ended(hit), ...); }
};

// The clamp comes first, so that the other recorders record the light that remains. The specular
// motion comes after the first hit, whose velocity it reads.
using AllRecorders =
    RecorderList<ClampRecorder, FirstHitRecorder, SpecularMotionRecorder, LightGroupRecorder,
                 PathLayerRecorder, FeatureRecorder, CatcherRecorder, OcclusionRecorder>;

}  // namespace emberline
