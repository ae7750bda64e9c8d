// Views of the first surface for debugging a scene: `normal`, `uv`, `albedo`, `depth` and
// `material_id`. Values are linear; nothing hit is black with alpha 0.
#pragma once

#include "integrators/integrator.h"

namespace emberline {

enum class DebugView {
  kNormal,      // shading normal, world axes, [-1, 1] mapped to [0, 1]
  kUv,          // TEXCOORD_0 modulo 1 in red and green
  kAlbedo,      // directional albedo
  kDepth,       // along the viewing axis, scene units, grey
  kMaterialId,  // a colour per material
};

class DebugIntegrator final : public Integrator {
 public:
  explicit DebugIntegrator(DebugView view) : view_(view) {}
  void estimate(const SampleBatch& batch, PixelSamples& samples,
                std::span<SampleValue> values) const override;

 private:
  DebugView view_;
};

}  // namespace emberline
