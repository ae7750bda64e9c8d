// Records a path's DenoiserFeatures while it is traced. A denoiser is guided by the surfaces that
// mirrors and clear glass show, not by the mirrors.
#pragma once

#include <cstdint>

#include "integrators/surface_shading.h"

namespace emberline {

class FeatureRecorder {
 public:
  // Each vertex of the path as it is shaded; the ray that came to it has this length. A path that
  // ends before a surface that scatters in all directions shows its last.
  void see(const SampleBatch& batch, const Ray& ray, float length, const ShadedPoint& point,
           const SurfaceBsdf& bsdf, const Rgb& throughput, DenoiserFeatures* features);
  // The light that was sampled at the vertex is not hidden.
  void see_light(DenoiserFeatures* features) const {
    if (state_ == State::kThere) features->visibility = 1.0f;
  }
  // The path has left the scene, towards this light.
  void see_background(const Rgb& light, DenoiserFeatures* features) const {
    if (state_ == State::kOnTheWay) *features = background(light);
  }
  static DenoiserFeatures background(const Rgb& light);

 private:
  enum class State : uint8_t { kOnTheWay, kThere, kPast };

  State state_ = State::kOnTheWay;
  float length_ = 0.0f;       // of the path
  float axial_share_ = 0.0f;  // of its length that is along the viewing axis
};

}  // namespace emberline
