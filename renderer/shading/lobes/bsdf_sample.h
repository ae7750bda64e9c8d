// The result of sampling a scattering function.
#pragma once

#include "renderer/core/vector.h"

namespace emberline {

struct BsdfSample {
  Vec3f wi = Vec3f(0.0f);
  Rgb weight = Rgb(0.0f);  // eval / pdf; for a delta lobe, albedo / pick probability
  float pdf = 0.0f;        // of all lobes together; 0 for a delta lobe
  // Square of the relative index of refraction if the sample enters another medium, otherwise 1.
  // `weight` contains the inverse of this factor. For Russian roulette, a path's weight is
  // multiplied by the product of its eta_scales; otherwise roulette would end every second path
  // into glass.
  float eta_scale = 1.0f;
  bool delta = false;
  bool transmitted = false;  // wi is on the other side of the surface from wo
  bool valid = false;        // if false, light is absorbed and the path ends
};

}  // namespace emberline
