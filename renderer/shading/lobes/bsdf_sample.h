// The result of sampling a scattering function.
#pragma once

#include "renderer/core/vector.h"

namespace emberline {

struct BsdfSample {
  Vec3f wi = Vec3f(0.0f);
  Rgb weight = Rgb(0.0f);  // eval / pdf; for a delta lobe its albedo over its pick probability
  float pdf = 0.0f;        // of all lobes together; 0 with delta = true for a delta lobe
  // Square of the relative index of refraction of the medium entered, otherwise 1. Radiance is
  // scaled by its inverse on the way, so Russian roulette uses weight * (product of these);
  // otherwise it would terminate every second path into glass.
  float eta_scale = 1.0f;
  bool delta = false;
  bool transmitted = false;  // wi is on the other side of the surface from wo
  bool valid = false;        // false: absorbed, end the path
};

}  // namespace emberline
