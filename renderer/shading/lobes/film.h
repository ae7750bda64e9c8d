// A thin film on a surface.
#pragma once

#include "renderer/core/vector.h"
#include "renderer/shading/lobes/thin_film.h"

namespace emberline {

// KHR_materials_iridescence at a point; strength 0: no film.
struct Film {
  float strength = 0.0f;   // [0, 1]
  float ior = 1.3f;        // >= 1
  float thickness = 0.0f;  // nanometres

  bool exists() const { return strength > 0.0f; }
  // With the film, of a base that reflects base_f0 at normal incidence.
  Rgb reflectance(float cos_i, const Rgb& base_f0) const {
    return thin_film_reflectance(cos_i, ior, thickness, base_f0);
  }
};

}  // namespace emberline
