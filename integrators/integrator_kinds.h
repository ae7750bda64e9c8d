// The factories that the integrator table uses.
#pragma once

#include "integrators/integrator.h"

namespace emberline {

std::unique_ptr<Integrator> create_path(const IntegratorSettings& settings);
std::unique_ptr<Integrator> create_ambient_occlusion(const IntegratorSettings& settings);

enum class DebugView {
  kNormal,      // shading normal, world axes, [-1, 1] mapped to [0, 1]
  kUv,          // TEXCOORD_0 modulo 1 in red and green
  kAlbedo,      // directional albedo
  kDepth,       // depth along the viewing axis in scene units, as grey
  kMaterialId,  // a colour per material
  kGuide,       // the direction of most indirect light, coloured like kNormal; grey: no guide
};
std::unique_ptr<Integrator> create_debug(DebugView view);

}  // namespace emberline
