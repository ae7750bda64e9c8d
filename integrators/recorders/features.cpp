#include "integrators/recorders/features.h"

#include <algorithm>

#include "renderer/scene/camera.h"

namespace emberline {
namespace {

Rgb at_most_1(const Rgb& colour) {
  return {std::min(colour.x, 1.0f), std::min(colour.y, 1.0f), std::min(colour.z, 1.0f)};
}

}  // namespace

DenoiserFeatures FeatureRecorder::background(const Rgb& light) {
  return {.albedo = at_most_1(light)};
}

void FeatureRecorder::see(const SampleBatch& batch, const Ray& ray, float length,
                          const ShadedPoint& point, const SurfaceBsdf& bsdf, const Rgb& throughput,
                          DenoiserFeatures* features) {
  if (state_ != State::kOnTheWay) {
    state_ = State::kPast;
    return;
  }
  if (length_ == 0.0f) {
    axial_share_ = batch.camera.axial_depth(point.surface.position, ray.time) / length;
  }
  length_ += length;
  const bool unlit = point.surface.material->unlit();
  const Rgb albedo = unlit ? Rgb(0.0f) : bsdf.albedo();
  features->albedo = at_most_1(throughput * (albedo + point.material.emission));
  features->normal = point.frame.shading.normal;
  const float nearness = float(batch.scene.scale()) / (axial_share_ * length_);
  features->nearness = nearness < DenoiserFeatures::kMostNearness ? std::max(nearness, 0.0f)
                                                                  : DenoiserFeatures::kMostNearness;
  if (unlit || bsdf.has_non_delta()) state_ = State::kThere;
}

}  // namespace emberline
