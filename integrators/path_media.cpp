#include "integrators/path_media.h"

#include "renderer/shading/lobes/wavelength.h"

namespace emberline {

void set_relative_ior(const Interior& in, PixelSamples& samples, PathWavelength& wavelength,
                      ShadedPoint& point) {
  wavelength.bends = false;
  const Material* own = solid_material(point);
  if (!own) return;
  const Material* other = point.frame.back_facing ? interior_behind(point, in).solid : in.solid;
  wavelength.bends = own->dispersion() > 0.0f || (other && other->dispersion() > 0.0f);
  if (wavelength.bends && wavelength.nanometres == 0.0f) {
    const SampledWavelength sampled = sample_wavelength(samples.extra());
    wavelength = {sampled.nanometres, sampled.weight, true};
  }
  const auto ior_of = [&](const Material& solid) {
    return solid.dispersion() > 0.0f
               ? ior_at(solid.ior(), solid.dispersion(), wavelength.nanometres)
               : solid.ior();
  };
  BsdfParameters& bsdf = point.material.bsdf;
  bsdf.ior = ior_of(*own);
  // 0 reflects everything, whatever is around it.
  if (!other || !(bsdf.ior > 0.0f) || !(other->ior() > 0.0f)) return;
  // The lobe's index is at least 1, its `inside` the denser side.
  bsdf.ior /= ior_of(*other);
  if (bsdf.ior < 1.0f) {
    bsdf.ior = 1.0f / bsdf.ior;
    bsdf.inside = !bsdf.inside;
  }
}

namespace {

// What the surface that was hit lets straight through; `*beyond` is where the way goes on.
Rgb through_surface(const Scene& scene, const Vec3f& direction, float time, const SurfaceHit& hit,
                    float u_texture, Vec3f* beyond) {
  if (!scene.material_of(hit.instance).is_smooth_wall()) return Rgb(0.0f);
  const ShadedPoint point =
      shade(scene, Ray{Vec3f(0.0f), direction, kInfinity, time}, hit, u_texture);
  *beyond = point.spawn_origin(direction);
  return point.bsdf().straight_through();
}

}  // namespace

Rgb through_thin_walls(const Scene& scene, Vec3f from, const LightSample& light,
                       const Vec3f& target, float time, CoverageKey coverage_key,
                       PixelSamples& samples, SampleRays* rays) {
  const bool infinite = light.distance == kInfinity;
  Rgb through(1.0f);
  for (uint32_t walls = 0; walls <= kMostWalls; ++walls) {
    // As Scene::visible has it: aimed anew, and t = 1 is the far point exactly.
    const Ray ray = infinite ? Ray{from, light.direction, kInfinity, time}
                             : Ray{from, target - from, 1.0f, time};
    if (!infinite && !(dot(ray.direction, light.direction) > 0.0f)) return through;
    SurfaceHit hit;
    rays->shadow++;
    // One key for the whole way: no part of it is met twice.
    if (!scene.intersect(ray, coverage_key, &hit)) {
      return scene.behind_flush_emitter(from, light, time, coverage_key) ? Rgb(0.0f) : through;
    }
    through *= through_surface(scene, light.direction, time, hit, samples.extra(), &from);
    if (is_black(through)) return through;
  }
  return Rgb(0.0f);
}

}  // namespace emberline
