// The parameters that glTF extensions add to the metallic-roughness model at a surface point.
#pragma once

#include <algorithm>
#include <cmath>

#include "renderer/core/vector.h"

namespace emberline {

// Complements BsdfParameters for a material with any of these extensions. Each default means that
// its extension is absent. Weights, roughnesses and colours are in [0, 1].
struct LayerParameters {
  // Whether wo is behind the face. If so, the coat and the sheen of a solid are on the far side of
  // the face. This flag may differ from BsdfParameters::inside: where two solids touch, `inside`
  // tells whether wo is in the denser one.
  bool behind = false;
  // KHR_materials_anisotropy, for the base's reflection.
  float anisotropy = 0.0f;
  Vec2f anisotropy_direction = Vec2f(1.0f, 0.0f);  // unit, x and y of local shading space
  // KHR_materials_iridescence
  float iridescence = 0.0f;
  float iridescence_ior = 1.3f;        // >= 1
  float iridescence_thickness = 0.0f;  // nanometres, >= 0
  // KHR_materials_diffuse_transmission
  float diffuse_transmission = 0.0f;
  Rgb diffuse_transmission_color = Rgb(1.0f);
  // KHR_materials_sheen
  Rgb sheen_color = Rgb(0.0f);
  float sheen_roughness = 0.0f;
  // KHR_materials_clearcoat
  float clearcoat = 0.0f;
  float clearcoat_roughness = 0.0f;
  Vec3f clearcoat_normal = Vec3f(0.0f, 0.0f, 1.0f);  // unit, local shading space
};

// The layers as a material defines them. Directions are in tangent space, with x along the mesh's
// tangent.
struct MaterialLayers {
  LayerParameters parameters;
  bool has_clearcoat_normal_map = false;  // if false, use the vertex normal, not clearcoat_normal
};

// Returns the fraction of the emission from below that a clear coat transmits. `cosine` is that of
// the angle to the geometric normal (KHR_materials_clearcoat, "Emission").
inline float emission_through_coat(float clearcoat, float cosine) {
  const float m = 1.0f - std::min(1.0f, std::abs(cosine));
  return 1.0f - clearcoat * fma(0.96f * square(square(m)), m, 0.04f);
}

}  // namespace emberline
