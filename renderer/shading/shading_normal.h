// Converts the normals of a hit to a frame for scattering.
//
// All functions are pure and work in world space (or any space that does not distort lengths);
// directions are unit vectors unless stated otherwise. The tilt of make_surface_frame() and the
// terminator factor are not reciprocal. This is an inherent cost of shading normals (Veach 1997,
// thesis, section 5.3).
#pragma once

#include "renderer/core/frame.h"
#include "renderer/core/vector.h"

namespace emberline {

// The frame of a hit, with both normals on wo's side.
struct SurfaceFrame {
  ShadingFrame shading;      // normal is +Z of local space; dot(normal, wo) > 0 up to rounding
  Vec3f geometric_normal;    // world; dot with wo >= 0
  bool back_facing = false;  // wo was behind the face, whose CCW side is the front
};

// Returns the normal given by a tangent-space map: x T + y B + z N with B = w cross(N, T), without
// intermediate normalisation (MikkTSpace convention). `normal` and `tangent`.xyz are interpolated,
// in world space. If the instance's transform has a negative determinant, which reverses cross
// products, the caller negates w. An unusable tangent (zero, or parallel to the normal) is replaced
// by an arbitrary one. The result is a unit vector on `normal`'s side of the surface.
Vec3f mapped_normal(const Vec3f& normal, const Vec4f& tangent, const Vec3f& map_normal);

// Builds the frame. `face_normal` is the unit geometric normal, on the side from which the
// triangle's vertices run counter-clockwise (for a mirrored instance, on the transformed front
// side). `vertex_normal` is interpolated and may have any length; if it is too short or not finite,
// the face normal is used. `shading_normal` is the mapped normal, or `vertex_normal` if there is no
// normal map. `wo` is a unit vector.
//
// The face normal is flipped to wo's side. If the vertex normal then points to the opposite side of
// the surface, the shading normal is flipped, because vertex normals may disagree with the winding.
// Then the shading normal is tilted towards the geometric normal Ng, as far as needed to keep the
// mirror direction R of wo above the surface: R.Ng >= min(0.9 Ng.wo, 0.01) (Keller et al. 2017,
// "The Iray Light Transport Simulation and Rendering System", section A.3; the bound is taken from
// Cycles).
//
// Directions wi with dot(wi, geometric_normal) <= 0 are below the surface and get nothing from
// reflection lobes, whatever the shading normal is; SurfaceBsdf ensures this.
SurfaceFrame make_surface_frame(const Vec3f& face_normal, const Vec3f& vertex_normal,
                                const Vec3f& shading_normal, const Vec3f& wo);

// These functions soften the shadow terminator of cosine lobes by GGX masking, as if there were
// unseen microgeometry. The roughness of the microgeometry follows from the angle delta between the
// two normals: alpha^2 = tan^2(delta) / 8. See Estevez, Lecocq & Zeltner 2019, "A Microfacet-Based
// Shadowing Function to Solve the Bump Terminator Problem", Ray Tracing Gems, chapter 12. The
// softening is a factor of f itself, so light sampling and BSDF sampling both include it.
inline float terminator_alpha2(float cos_delta) {
  const float cos2 = square(cos_delta);
  // At a right angle, the roughness has its maximum (the chapter clamps to [0, 1]).
  if (!(cos2 > 0.0f)) return 1.0f;
  return std::clamp((1.0f - cos2) / cos2 * 0.125f, 0.0f, 1.0f);
}
// `cos_geometric` is dot(wi, geometric normal). The factor is in [0, 1], and 0 at and below the
// surface.
inline float terminator_factor(float cos_geometric, float alpha2) {
  if (!(cos_geometric > 0.0f)) return 0.0f;
  const float cos2 = square(cos_geometric);
  const float tan2 = std::max(0.0f, 1.0f - cos2) / cos2;
  return 2.0f / (1.0f + std::sqrt(fma(alpha2, tan2, 1.0f)));
}

}  // namespace emberline
