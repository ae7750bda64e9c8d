// `ambient_occlusion`: how much of the hemisphere above the first surface is open, 0 to 1. Rays are
// cosine-weighted around the shading normal and end after a fifth of the scene's radius (chosen by
// eye on interiors, which would be black with rays of any length).
#pragma once

#include "integrators/integrator.h"

namespace emberline {

class AmbientOcclusionIntegrator final : public Integrator {
 public:
  explicit AmbientOcclusionIntegrator(const IntegratorSettings& settings) : settings_(settings) {}
  void estimate(const SampleBatch& batch, PixelSamples& samples,
                std::span<SampleValue> values) const override;

 private:
  IntegratorSettings settings_;
};

}  // namespace emberline
