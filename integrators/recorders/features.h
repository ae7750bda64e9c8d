// Records DenoiserFeatures. At a mirror or clear glass, these are the features of the surface that
// is seen in the mirror or through the glass.
#pragma once

#include <algorithm>
#include <span>

#include "integrators/recorders/hooks.h"
#include "renderer/scene/camera.h"

namespace emberline {

class FeatureRecorder : public Recorder {
 public:
  explicit FeatureRecorder(PathBatch& batch) : Recorder(batch) {}
  static bool is_enabled(const SampleBatch& batch) { return !batch.features.empty(); }

  void begin(int lane) {
    if (!features_.empty()) states_.emplace(lane);
  }
  void background(int lane, const Rgb& radiance) {
    if (!features_.empty()) features_[size_t(lane)] = {.albedo = clamp_to_one(radiance)};
  }
  void shaded(int lane) {
    if (!features_.empty()) record_surface(lane);
  }
  Rgb environment(int lane, const Rgb& radiance, const Rgb& light) {
    if (!features_.empty()) leave(lane, b_.paths[lane].throughput * radiance);
    return light;
  }
  Rgb connected(int lane, const Rgb& light) {
    if (!features_.empty() && states_[lane].stage == Stage::kAtSurface) {
      features_[size_t(lane)].visibility = 1.0f;
    }
    return light;
  }
  void missed(int lane) {
    if (!features_.empty()) leave(lane, Rgb(0.0f));
  }

 private:
  enum class Stage : uint8_t { kSpecularPath, kAtSurface, kDone };
  struct State {
    Stage stage = Stage::kSpecularPath;
    float length = 0.0f;              // length of the path so far
    float depth_per_distance = 0.0f;  // depth divided by distance, along the camera ray
  };

  static Rgb clamp_to_one(const Rgb& colour) {
    return {std::min(colour.x, 1.0f), std::min(colour.y, 1.0f), std::min(colour.z, 1.0f)};
  }
  void leave(int lane, const Rgb& light) {
    if (states_[lane].stage == Stage::kSpecularPath) background(lane, light);
  }
  // Each specular surface overwrites the features. So if a path meets only specular surfaces, the
  // features of the last one remain.
  void record_surface(int lane) {
    State& state = states_[lane];
    if (state.stage == Stage::kSpecularPath) {
      set_features(b_.paths[lane], b_.points[lane], b_.bsdfs[lane], &state,
                   &features_[size_t(lane)]);
    } else {
      state.stage = Stage::kDone;
    }
  }
  void set_features(const Path& path, const ShadedPoint& point, const SurfaceBsdf& bsdf,
                    State* state, DenoiserFeatures* features) {
    const float length = path.hit.t;
    if (state->length == 0.0f) {
      const float depth = b_.batch.camera.axial_depth(point.surface.position, path.ray.time);
      state->depth_per_distance = depth / length;
    }
    state->length += length;
    const bool unlit = point.surface.material->unlit();
    const Rgb albedo = unlit ? Rgb(0.0f) : bsdf.albedo();
    features->albedo = clamp_to_one(path.throughput * (albedo + point.material.emission));
    features->normal = point.frame.shading.normal;
    constexpr float kLimit = DenoiserFeatures::kMaxNearness;
    const float nearness = float(b_.scene.scale()) / (state->depth_per_distance * state->length);
    features->nearness = nearness < kLimit ? std::max(nearness, 0.0f) : kLimit;
    if (unlit || bsdf.has_non_delta()) state->stage = Stage::kAtSurface;
  }

  const std::span<DenoiserFeatures> features_ = b_.batch.features;  // not recorded if empty
  LaneArray<State> states_;
};

}  // namespace emberline
