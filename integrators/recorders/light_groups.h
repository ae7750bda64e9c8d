// Records the radiance by light group (SampleBatch::light_values).
#pragma once

#include "integrators/recorders/hooks.h"
#include "renderer/film/light_group_values.h"
#include "renderer/scene/light_groups.h"

namespace emberline {

// Looks up the light groups of the light that paths find. Each function returns 0 if the batch has
// no light groups.
class BatchLightGroups {
 public:
  explicit BatchLightGroups(PathBatch& batch) : b_(batch), groups_(batch.batch.light_groups) {}
  uint32_t of_surface(int lane) {
    return groups_ ? groups_->of_material(b_.points[lane].surface.material_index) : 0;
  }
  uint32_t of_environment() const { return groups_ ? groups_->of_environment() : 0; }
  uint32_t of_connection(int lane) {
    if (!groups_) return 0;
    const LightSample& light = b_.connections[lane].light;
    if (light.kind == LightKind::kPoint) return groups_->of_point(light.index);
    if (light.kind == LightKind::kEnvironment) return groups_->of_environment();
    const EmissiveTriangle& triangle = b_.lights.triangles()[light.index];
    return groups_->of_material(b_.scene.material_index_of(triangle.instance));
  }

 private:
  PathBatch& b_;
  const LightGroups* const groups_;
};

class LightGroupRecorder : public Recorder {
 public:
  explicit LightGroupRecorder(PathBatch& batch) : Recorder(batch) {}
  static bool is_enabled(const SampleBatch& batch) { return batch.light_values; }

  void background(int lane, const Rgb& radiance) {
    if (values_) values_->add(lane, groups_.of_environment(), Rgb(1.0f), radiance);
  }
  Rgb emitted(int lane, const Rgb& light) {
    return values_ ? add(lane, groups_.of_surface(lane), light) : light;
  }
  Rgb environment(int lane, const Rgb&, const Rgb& light) {
    return values_ ? add(lane, groups_.of_environment(), light) : light;
  }
  Rgb connected(int lane, const Rgb& light) {
    return values_ ? add(lane, groups_.of_connection(lane), light) : light;
  }

 private:
  Rgb add(int lane, uint32_t group, const Rgb& light) {
    values_->add(lane, group, b_.paths[lane].throughput, light);
    return light;
  }

  BatchLightGroups groups_{b_};
  LightGroupValues* const values_ = b_.batch.light_values;  // null if not recorded
};

}  // namespace emberline
