// What lies between two vertices of a path: the insides of solids, and thin walls.
#pragma once

#include "integrators/integrator.h"
#include "integrators/surface_shading.h"

namespace emberline {

// Of one ray; none is made for opaque scenes.
inline CoverageKey coverage_key(const Scene& scene, PixelSamples& samples) {
  return scene.has_coverage() ? samples.coverage_key() : CoverageKey();
}

// A solid's material, if the point lies on one.
inline const Material* solid_material(const ShadedPoint& point) {
  const Material* material = point.surface.material;
  return material->passes_light() && !point.material.bsdf.thin_walled ? material : nullptr;
}

// The solids that a path is inside of: the innermost, and the one around it. In a third one the
// outermost is forgotten; its back face, met on the way out, says so, as it does to a camera that
// stands in one.
struct Interior {
  const Material* solid = nullptr;
  const Material* outer = nullptr;
};

// What lies on the other side of the point's surface, seen from a path that is inside `in`.
inline Interior interior_behind(const ShadedPoint& point, const Interior& in) {
  const Material* own = solid_material(point);
  if (!own) return in;  // a thin wall, or no passage at all
  if (!point.frame.back_facing) return {own, in.solid};
  // Solids that overlap may be left in the order that they were entered in.
  if (own == in.outer && own != in.solid) return {in.solid, nullptr};
  return {in.outer, nullptr};
}

// What dispersion has made of a path: all of it has one wavelength from the first face on that
// bends colours apart, and counts by that wavelength's colour once it has been bent.
struct PathWavelength {
  float nanometres = 0.0f;  // 0: none yet
  Rgb weight = Rgb(1.0f);   // that does not count yet
  bool bends = false;       // the face at hand bends by wavelength
};

// A face between two solids bends by the ratio of their indices, each at the path's wavelength, for
// which `samples` is asked where it is needed for the first time.
void set_relative_ior(const Interior& in, PixelSamples& samples, PathWavelength& wavelength,
                      ShadedPoint& point);

// Absorption of a solid (or of nothing: 1) over an internal distance; a light at infinity is taken
// to be beyond the scene, whose own size bounds what can lie in between.
inline Rgb absorption(const Scene& scene, const Material* solid, float distance) {
  if (!solid) return Rgb(1.0f);
  const float within = std::min(distance, 2.0f * scene.radius());
  return beer_transmittance(solid->attenuation(), float(double(within) / scene.scale()));
}

// Smooth thin walls that a ray goes straight through in a row, sampled or on its way to a light:
// the same for both, since they find the same light. Ours: more than a picture can show.
inline constexpr uint32_t kMostWalls = 64;

// What arrives of a sampled light: what smooth thin walls on the way let straight through, 1
// without any, 0 if anything else is in the way. `target` is where the way ends; not read if the
// light is infinitely far. For scenes with such walls.
Rgb through_thin_walls(const Scene& scene, Vec3f from, const LightSample& light,
                       const Vec3f& target, float time, CoverageKey coverage_key,
                       PixelSamples& samples, SampleRays* rays);

}  // namespace emberline
