// Records the radiance by light-path layer (PathLayer).
#pragma once

#include <algorithm>

#include "integrators/recorders/hooks.h"
#include "renderer/film/light_group_values.h"
#include "renderer/film/path_layers.h"

namespace emberline {

class PathLayerRecorder : public Recorder {
 public:
  explicit PathLayerRecorder(PathBatch& batch) : Recorder(batch) {}
  static bool is_enabled(const SampleBatch& batch) { return batch.layer_values; }

  void begin(int lane) {
    if (values_) first_events_.emplace(lane);
  }
  void background(int lane, const Rgb& radiance) {
    if (!values_) return;
    values_->add(lane, layers_->index_of(PathLayer::kEnvironment), Rgb(1.0f), radiance);
  }
  Rgb emitted(int lane, const Rgb& light) {
    if (values_) add(lane, first_events_[lane], PathLayer::kEmission, light);
    return light;
  }
  Rgb environment(int lane, const Rgb&, const Rgb& light) {
    if (values_) add(lane, first_events_[lane], PathLayer::kEnvironment, light);
    return light;
  }
  Rgb connected(int lane, const Rgb& light) {
    if (values_) add_connection(lane, light);
    return light;
  }
  void scattered(int lane, const BsdfSample& next) {
    if (!values_) return;
    Event& first = first_events_[lane];
    if (first.kind == Kind::kNone) {
      first = event_along(lane, next.wi, next.transmitted, next.delta);
    } else if (!(next.delta && next.transmitted && b_.points[lane].material.bsdf.thin_walled)) {
      first.is_scattered_again = true;
    }
  }

 private:
  // The way in which the path left the first surface.
  enum class Kind : uint8_t { kNone, kReflected, kTransmitted };
  struct Event {
    Kind kind = Kind::kNone;
    bool is_scattered_again = false;  // whether the path was scattered again
    Rgb diffuse = Rgb(0.0f);          // diffuse fraction of the reflected light
  };

  // Returns the event at the path's vertex if the path leaves it in direction `wi`, which is in
  // local space.
  Event event_along(int lane, const Vec3f& wi, bool transmitted, bool delta) {
    if (transmitted) return {Kind::kTransmitted};
    Event event{Kind::kReflected};
    if (delta) return event;
    const Rgb all = b_.bsdfs[lane].eval(wi), diffuse = b_.bsdfs[lane].eval_diffuse(wi);
    for (int c = 0; c < 3; ++c) {
      event.diffuse[c] = all[c] > 0.0f ? std::min(1.0f, diffuse[c] / all[c]) : 0.0f;
    }
    return event;
  }
  void add_connection(int lane, const Rgb& light) {
    Event first = first_events_[lane];
    if (first.kind == Kind::kNone) {
      const Vec3f& direction = b_.connections[lane].light.direction;
      const Vec3f wi = b_.points[lane].frame.shading.to_local(direction);
      first = event_along(lane, wi, wi.z < 0.0f, false);
    } else {
      first.is_scattered_again = true;
    }
    add(lane, first, PathLayer::kEmission, light);
  }
  // `unscattered` is the layer for light that no surface has scattered.
  void add(int lane, const Event& first, PathLayer unscattered, const Rgb& light) {
    if (first.kind == Kind::kNone) return add_to(lane, unscattered, light);
    if (first.kind == Kind::kTransmitted) return add_to(lane, PathLayer::kTransmission, light);
    const Rgb diffuse = light * first.diffuse;
    add_to(lane, first.is_scattered_again ? PathLayer::kIndirect : PathLayer::kDirect, diffuse);
    add_to(lane, PathLayer::kReflection, light - diffuse);
  }
  void add_to(int lane, PathLayer layer, const Rgb& light) {
    values_->add(lane, layers_->index_of(layer), b_.paths[lane].throughput, light);
  }

  const PathLayers* const layers_ = b_.batch.path_layers;
  LightGroupValues* const values_ = b_.batch.layer_values;  // null if not recorded
  LaneArray<Event> first_events_;
};

}  // namespace emberline
