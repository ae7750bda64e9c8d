#include "integrators/ambient_occlusion_integrator.h"

#include "integrators/path_media.h"
#include "renderer/core/warps.h"
#include "samplers/pixel_samples.h"

namespace emberline {
namespace {

constexpr float kRadiusFraction = 0.2f;

}  // namespace

void AmbientOcclusionIntegrator::estimate(const SampleBatch& batch, PixelSamples& samples,
                                          std::span<SampleValue> values) const {
  const Scene& scene = batch.scene;
  for (size_t i = 0; i < batch.rays.size(); ++i) {
    samples.start_sample(int(i));
    SampleValue& value = values[i];
    value = SampleValue{};
    SurfaceHit hit;
    const CoverageKey camera_key = coverage_key(scene, samples);
    if (!scene.intersect(batch.rays[i], camera_key, &hit)) {
      if (!settings_.transparent) value = {Rgb(1.0f), 1.0f, {}, {}};  // nothing occludes the sky
      continue;
    }
    samples.start_slot(1);
    const ShadedPoint point = shade(scene, batch.rays[i], hit, samples.get(surface_dim::kTexture));
    value.alpha = 1.0f;
    fill_first_hit(batch, hit, point, batch.rays[i].time, point.bsdf().albedo(), &value.first_hit);
    const Vec3f direction = point.frame.shading.to_world(square_to_cosine_hemisphere(
        {samples.get(surface_dim::kBsdfX), samples.get(surface_dim::kBsdfY)}));
    if (dot(direction, point.frame.geometric_normal) <= 0.0f) continue;
    const Vec3f from = point.spawn_origin(direction);
    value.rays.shadow++;
    const CoverageKey shadow_key = coverage_key(scene, samples);
    const Vec3f to = from + direction * (kRadiusFraction * scene.radius());
    value.radiance = Rgb(scene.transmittance(from, to, batch.rays[i].time, shadow_key));
  }
}

}  // namespace emberline
