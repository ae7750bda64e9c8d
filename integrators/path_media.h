// The interiors of solids and the thin walls that a path crosses between two vertices.
#pragma once

#include "integrators/integrator.h"
#include "integrators/surface_shading.h"
#include "renderer/scene/interior.h"
#include "samplers/pixel_samples.h"

namespace emberline {

// Returns the coverage key of one ray. Scenes without alpha use the default key.
inline CoverageKey coverage_key(const Scene& scene, PixelSamples& samples) {
  return scene.has_coverage() ? samples.coverage_key() : CoverageKey();
}

// Dispersion of a path. The path gets one wavelength at the first face that disperses. Its
// throughput is multiplied by the colour of this wavelength when a dispersive face first transmits
// the path.
struct PathWavelength {
  float nanometres = 0.0f;     // 0 if none has been sampled yet
  Rgb weight = Rgb(1.0f);      // not yet multiplied into the throughput
  bool is_dispersive = false;  // the current face disperses
};

// Sets the relative index of refraction of a solid's face from the media on both sides. Uses the
// path's wavelength, and samples it when it is first needed. `near` is the side that the path comes
// from.
void set_relative_ior(const Interior& near, const Interior& far, PixelSamples& samples,
                      PathWavelength& wavelength, ShadedPoint& point);

// is_flat_solid() tells whether the hit is on a flat solid, which acts as a thin wall.
// is_smooth_wall() tells whether the hit is on a thin wall or flat solid through which light goes
// straight.
inline bool is_flat_solid(const Scene& scene, const SurfaceHit& hit) {
  return scene.solids() && scene.solids()->is_flat(hit.instance);
}
inline bool is_smooth_wall(const Scene& scene, const SurfaceHit& hit) {
  const Material& material = scene.material_of(hit.instance);
  return material.is_smooth_wall() || (material.is_smooth_solid() && is_flat_solid(scene, hit));
}
// Turns a face of a flat solid into a thin wall.
void make_thin_walled(const Interior& around, ShadedPoint& point);

// Returns the deterministic BSDF sample of a path that may not scatter: the path goes straight
// through.
inline BsdfSample straight_sample(const SurfaceBsdf& bsdf) {
  BsdfSample sample;
  sample.weight = bsdf.straight_transmittance();
  sample.delta = sample.transmitted = sample.valid = true;
  return sample;
}

// Returns whether the path goes straight through a face without seeing it. This is so if the same
// solid fills both sides, or if both sides have the same index of refraction and dispersion and the
// face only refracts. Emissive faces are never hidden, since light sampling does not know what
// surrounds them.
inline bool is_hidden(const Scene& scene, const SolidCrossing& crossing, const Interior& near,
                      const Interior& far, uint32_t instance) {
  const Material* const a = near.medium();
  const Material* const b = far.medium();
  if (a != b) {
    const float ior_a = a ? a->ior() : 1.0f, ior_b = b ? b->ior() : 1.0f;
    if (ior_a != ior_b || !(ior_a > 0.0f) || !scene.solids()->is_clear(instance)) return false;
    if ((a ? a->dispersion() : 0.0f) != (b ? b->dispersion() : 0.0f)) return false;
  } else if (!a) {
    return false;
  }
  return !crossing.empty() && !scene.material_of(instance).is_emissive();
}

// Returns the transmittance of a solid over a distance in internal space, or 1 if `medium` is null.
// The distance to a light may be infinite, so the distance is limited to twice the scene's radius;
// no path through a solid is longer.
inline Rgb absorption(const Scene& scene, const Material* medium, float distance) {
  if (!medium) return Rgb(1.0f);
  const float limited_distance = std::min(distance, 2.0f * scene.radius());
  return beer_transmittance(medium->attenuation(), float(double(limited_distance) / scene.scale()));
}

// Maximum number of consecutive smooth thin walls or hidden faces that a sampled ray or a
// connection passes. Sampled rays and connections have the same limit, since they must find the
// same light. The limit bounds the work in scenes with very many walls; the report says how many
// rays it ended (OpticsCounters).
inline constexpr uint32_t kMaxWalls = 10'000;

// Returns the transmittance of the connection from `from` to a sampled light. Smooth thin walls,
// and the solids behind hidden faces, attenuate the light. If anything else lies in between, the
// transmittance is 0. `target` is the end of the connection; it is unused for lights at infinity.
//
// On entry, `*interior` is the interior at `from`. On return, it is the interior at the end of the
// connection, and its medium begins at the distance `*medium_start` from `from`. The result lacks
// the absorption of this last medium, which the caller must apply.
Rgb clear_transmittance(const Scene& scene, Vec3f from, const LightSample& light,
                        const Vec3f& target, float time, CoverageKey coverage_key,
                        Interior* interior, float* medium_start, PixelSamples& samples,
                        SampleRays* rays, OpticsCounters* counters);

// Returns whether a point-like light, which only light sampling finds, is blocked by smooth glass
// of any shape and by nothing else. Used for statistics.
bool is_blocked_only_by_glass(const Scene& scene, Vec3f from, const LightSample& light,
                              const Vec3f& target, float time, CoverageKey coverage_key);

}  // namespace emberline
