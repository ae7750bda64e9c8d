#include "integrators/ambient_visibility.h"

#include "integrators/path_media.h"
#include "renderer/core/warps.h"
#include "samplers/pixel_samples.h"

namespace emberline {

float ambient_visibility(const Scene& scene, const ShadedPoint& point, float time,
                         PixelSamples& samples, SampleRays* rays) {
  constexpr float kMaxDistanceFraction = 0.2f;
  const Vec3f direction = point.frame.shading.to_world(square_to_cosine_hemisphere(
      {samples.get(surface_dim::kBsdfX), samples.get(surface_dim::kBsdfY)}));
  if (dot(direction, point.frame.geometric_normal) <= 0.0f) return 0.0f;
  const Vec3f from = point.spawn_origin(direction);
  if (rays) rays->shadow++;
  const CoverageKey key = coverage_key(scene, samples);
  const Vec3f to = from + direction * (kMaxDistanceFraction * scene.radius());
  return scene.transmittance(from, to, time, key);
}

}  // namespace emberline
