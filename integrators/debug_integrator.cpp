// Integrators that show the first surface, for debugging a scene: `normal`, `uv`, `albedo`,
// `depth`, `material_id` and `guide`. Values are linear. If a camera ray hits nothing, its sample
// is black with alpha 0.
#include <cmath>

#include "integrators/integrator_kinds.h"
#include "integrators/path_media.h"
#include "renderer/scene/camera.h"
#include "renderer/scene/indirect_guide.h"
#include "samplers/pixel_samples.h"

namespace emberline {
namespace {

float fraction(float x) {
  const float f = x - std::floor(x);
  return f >= 0.0f && f < 1.0f ? f : 0.0f;  // 0 also for infinities and NaN
}

Rgb material_color(uint32_t index) {
  const uint32_t h = hash_combine(0x9e37u, index);
  return {0.15f + 0.85f * float(h & 255) / 255.0f, 0.15f + 0.85f * float((h >> 8) & 255) / 255.0f,
          0.15f + 0.85f * float((h >> 16) & 255) / 255.0f};
}

// The direction from which the guide expects most light, as a colour like that of a normal. Grey:
// the surface has no guide.
Rgb guide_color(const SampleBatch& batch, const ShadedPoint& point) {
  const ShadingFrame& frame = point.frame.shading;
  const GuideCell* const cell =
      batch.indirect_guide && point.bsdf().can_be_guided()
          ? batch.indirect_guide->find(point.surface.position, frame.normal)
          : nullptr;
  if (!cell) return Rgb(0.1f);
  return (frame.to_world(cell->directions.main_direction()) + Vec3f(1.0f)) * 0.5f;
}

Rgb view_color(DebugView view, const SampleBatch& batch, const ShadedPoint& point, float time) {
  switch (view) {
    case DebugView::kNormal:
      return (point.frame.shading.normal + Vec3f(1.0f)) * 0.5f;
    case DebugView::kUv: {
      const Vec2f& uv = point.surface.attributes.uv[0];
      return {fraction(uv.x), fraction(uv.y), 0.0f};
    }
    case DebugView::kAlbedo:
      return point.surface.material->unlit() ? point.material.emission : point.bsdf().albedo();
    case DebugView::kDepth:
      return Rgb(float(double(batch.camera.axial_depth(point.surface.position, time)) /
                       batch.scene.scale()));
    case DebugView::kMaterialId:
      return material_color(point.surface.material_index);
    case DebugView::kGuide:
      return guide_color(batch, point);
  }
  return Rgb(0.0f);
}

class DebugIntegrator final : public Integrator {
 public:
  explicit DebugIntegrator(DebugView view) : view_(view) {}

  void estimate(const SampleBatch& batch, PixelSamples& samples,
                std::span<SampleValue> values) const override {
    if (batch.all_rays_miss) return;
    for (size_t i = 0; i < batch.rays.size(); ++i) {
      samples.start_sample(int(i));
      values[i] = SampleValue{};
      SurfaceHit hit;
      const CoverageKey key = coverage_key(batch.scene, samples);
      if (!batch.scene.intersect(batch.rays[i], key, &hit)) continue;
      samples.start_slot(1);
      const ShadedPoint point =
          shade(batch.scene, batch.rays[i], hit, samples.get(surface_dim::kTexture));
      fill_first_hit(batch, hit, point, batch.rays[i].time, point.bsdf().albedo(),
                     &values[i].first_hit);
      values[i].alpha = 1.0f;
      values[i].radiance = view_color(view_, batch, point, batch.rays[i].time);
    }
  }

 private:
  DebugView view_;
};

}  // namespace

std::unique_ptr<Integrator> create_debug(DebugView view) {
  return std::make_unique<DebugIntegrator>(view);
}

}  // namespace emberline
