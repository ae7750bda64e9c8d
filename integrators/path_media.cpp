#include "integrators/path_media.h"

namespace emberline {

Rgb through_thin_walls(const Scene& scene, Vec3f from, const Vec3f& direction, const Vec3f& target,
                       bool infinite, PixelSamples& samples, SampleRays* rays) {
  constexpr int kMostWalls = 64;  // ours: more panes in a row than a picture can show
  Rgb through(1.0f);
  for (int wall = 0; wall < kMostWalls; ++wall) {
    const float distance = infinite ? kInfinity : dot(target - from, direction);
    if (!(distance > 0.0f)) return through;
    SurfaceHit hit;
    const Ray ray{from, direction, distance};
    rays->shadow++;
    if (!scene.intersect(ray, coverage_key(scene, samples), &hit)) return through;
    if (!scene.material_of(hit.instance).has_transmission()) return Rgb(0.0f);
    const ShadedPoint point = shade(scene, ray, hit, samples.extra());
    if (!point.material.bsdf.thin_walled) return Rgb(0.0f);
    const float u_lobe = samples.extra();
    const float u_x = samples.extra();
    const BsdfSample next = point.bsdf().sample(u_lobe, {u_x, samples.extra()});
    if (!next.valid || !next.transmitted || !next.delta) return Rgb(0.0f);
    through *= next.weight;
    from = point.spawn_origin(direction);
  }
  return Rgb(0.0f);
}

}  // namespace emberline
