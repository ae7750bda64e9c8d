// `ambient_occlusion`: shows how open the hemisphere above the first surface is, from 0 to 1.
#include "integrators/ambient_visibility.h"
#include "integrators/integrator_kinds.h"
#include "integrators/path_media.h"
#include "samplers/pixel_samples.h"

namespace emberline {
namespace {

class AmbientOcclusionIntegrator final : public Integrator {
 public:
  explicit AmbientOcclusionIntegrator(const IntegratorSettings& settings) : settings_(settings) {}

  void estimate(const SampleBatch& batch, PixelSamples& samples,
                std::span<SampleValue> values) const override {
    const Scene& scene = batch.scene;
    for (size_t i = 0; i < batch.rays.size(); ++i) {
      const Ray& ray = batch.rays[i];
      samples.start_sample(int(i));
      SampleValue& value = values[i];
      value = SampleValue{};
      SurfaceHit hit;
      const CoverageKey camera_key = coverage_key(scene, samples);
      if (!scene.intersect(ray, camera_key, &hit)) {
        if (!settings_.transparent) value = {Rgb(1.0f), 1.0f, {}, {}};  // nothing occludes the sky
        continue;
      }
      samples.start_slot(1);
      const ShadedPoint point = shade(scene, ray, hit, samples.get(surface_dim::kTexture));
      value.alpha = 1.0f;
      fill_first_hit(batch, hit, point, ray.time, point.bsdf().albedo(), &value.first_hit);
      value.radiance = Rgb(ambient_visibility(scene, point, ray.time, samples, &value.rays));
    }
  }

 private:
  IntegratorSettings settings_;
};

}  // namespace

std::unique_ptr<Integrator> create_ambient_occlusion(const IntegratorSettings& settings) {
  return std::make_unique<AmbientOcclusionIntegrator>(settings);
}

}  // namespace emberline
