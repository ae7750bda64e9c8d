// `path`: unidirectional path tracing with next-event estimation. One light sample and one BSDF
// sample per vertex, combined by the balance heuristic (Veach & Guibas 1995, "Optimally Combining
// Sampling Techniques for Monte Carlo Rendering").
//
// `direct` is the same with a depth limit of 1.
#pragma once

#include "integrators/integrator.h"

namespace emberline {

class PathIntegrator final : public Integrator {
 public:
  explicit PathIntegrator(const IntegratorSettings& settings) : settings_(settings) {}
  void estimate(const SampleBatch& batch, PixelSamples& samples,
                std::span<SampleValue> values) const override;

 private:
  IntegratorSettings settings_;
};

}  // namespace emberline
