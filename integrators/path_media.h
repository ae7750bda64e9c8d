// What lies between two vertices of a path: the insides of solids, and thin walls.
#pragma once

#include "integrators/integrator.h"
#include "integrators/surface_shading.h"
#include "renderer/scene/interior.h"
#include "samplers/pixel_samples.h"

namespace emberline {

// Of one ray; none is made for opaque scenes.
inline CoverageKey coverage_key(const Scene& scene, PixelSamples& samples) {
  return scene.has_coverage() ? samples.coverage_key() : CoverageKey();
}

// What dispersion has made of a path: all of it has one wavelength from the first face on that
// bends colours apart, and counts by that wavelength's colour once it has been bent.
struct PathWavelength {
  float nanometres = 0.0f;  // 0: none yet
  Rgb weight = Rgb(1.0f);   // that does not count yet
  bool bends = false;       // the face at hand bends by wavelength
};

// Makes a solid's face bend by the ratio of the indices on its two sides, each at the path's
// wavelength, for which `samples` is asked where it is needed for the first time. `near` is the
// side that the path comes from.
void set_relative_ior(const Interior& near, const Interior& far, PixelSamples& samples,
                      PathWavelength& wavelength, ShadedPoint& point);

// Whether it is a face of a flat solid, which is a thin wall; and whether light goes straight
// through it, or any other wall.
inline bool is_flat_solid(const Scene& scene, const SurfaceHit& hit) {
  return scene.solids() && scene.solids()->is_flat(hit.instance);
}
inline bool is_smooth_wall(const Scene& scene, const SurfaceHit& hit) {
  const Material& material = scene.material_of(hit.instance);
  return material.is_smooth_wall() || (material.is_smooth_solid() && is_flat_solid(scene, hit));
}
// Makes a face of a flat solid a thin wall.
void make_wall(const Interior& around, ShadedPoint& point);

// The BSDF sample of a path that may not scatter: what goes straight on, without chance.
inline BsdfSample straight_on(const SurfaceBsdf& bsdf) {
  BsdfSample on;
  on.weight = bsdf.straight_through();
  on.delta = on.transmitted = on.valid = true;
  return on;
}

// Whether the path goes straight through a face without seeing it: where the same solid fills both
// of its sides, or both bend light alike and nothing else of the face shows. A face that shines is
// always seen, since light samples know nothing of its place.
inline bool is_hidden(const Scene& scene, const SolidCrossing& crossing, const Interior& near,
                      const Interior& far, uint32_t instance) {
  const Material* const a = near.solid();
  const Material* const b = far.solid();
  if (a != b) {
    const float ior_a = a ? a->ior() : 1.0f, ior_b = b ? b->ior() : 1.0f;
    if (ior_a != ior_b || !(ior_a > 0.0f) || !scene.solids()->is_clear(instance)) return false;
    if ((a ? a->dispersion() : 0.0f) != (b ? b->dispersion() : 0.0f)) return false;
  } else if (!a) {
    return false;
  }
  return !crossing.empty() && !scene.material_of(instance).is_emissive();
}

// Absorption of a solid (or of nothing: 1) over an internal distance; a light at infinity is taken
// to be beyond the scene, whose own size bounds what can lie in between.
inline Rgb absorption(const Scene& scene, const Material* solid, float distance) {
  if (!solid) return Rgb(1.0f);
  const float within = std::min(distance, 2.0f * scene.radius());
  return beer_transmittance(solid->attenuation(), float(double(within) / scene.scale()));
}

// Smooth thin walls, or hidden faces of solids, that a ray goes straight through in a row, sampled
// or on its way to a light: the same for both, since they find the same light. A guard against a
// scene that is all walls; the report tells of rays that were ended here (OpticsCounters).
inline constexpr uint32_t kMostWalls = 10'000;

// What arrives of a sampled light: what smooth thin walls on the way let straight through, 1
// without any, 0 if anything else is in the way. Hidden faces of solids are not. `target` is where
// the way ends; not read if the light is infinitely far. `interior` is where it begins, and then
// where it ends; `*travelled` how far from `from` that begins. What is absorbed from there on is
// the caller's to count.
Rgb through_clear_faces(const Scene& scene, Vec3f from, const LightSample& light,
                        const Vec3f& target, float time, CoverageKey coverage_key,
                        Interior* interior, float* travelled, PixelSamples& samples,
                        SampleRays* rays, OpticsCounters* counters);

// The same of a light that only samples can find, past smooth glass of any shape: what such glass
// alone keeps from a surface. For counting.
bool blocked_by_glass_alone(const Scene& scene, Vec3f from, const LightSample& light,
                            const Vec3f& target, float time, CoverageKey coverage_key);

}  // namespace emberline
