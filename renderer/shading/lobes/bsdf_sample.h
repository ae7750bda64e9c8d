// What sampling a scattering function returns.
#pragma once

#include "renderer/core/vector.h"

namespace emberline {

struct BsdfSample {
  Vec3f wi = Vec3f(0.0f);
  Rgb weight = Rgb(0.0f);  // eval / pdf; for a delta lobe its albedo over its pick probability
  float pdf = 0.0f;        // of all lobes together; 0 with delta = true for a delta lobe
  // Square of the relative index of refraction that the path entered, 1 otherwise. Radiance is
  // compressed by as much on the way; Russian roulette judges weight * (product of these), or it
  // would kill every second path into glass.
  float eta_scale = 1.0f;
  bool delta = false;
  bool transmitted = false;  // wi is on the other side of the surface from wo
  bool valid = false;        // false: absorbed, end the path
};

}  // namespace emberline
