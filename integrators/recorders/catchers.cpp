#include "integrators/recorders/catchers.h"

#include "integrators/path_media.h"
#include "integrators/sampled_light.h"

namespace emberline {
namespace {

// Limit on the surfaces between a catcher and a light; chosen to exceed any real scene.
constexpr int kMostPassed = 10'000;

Ray ray_to(const LightSample& light, const Vec3f& from, const Vec3f& target, float time) {
  return light.distance == kInfinity ? Ray{from, light.direction, kInfinity, time}
                                     : Ray{from, target - from, 1.0f, time};
}

// Whether a surface of the plate blocks the light.
bool plate_blocks(const Scene& scene, const SurfaceRoles& roles, Vec3f from,
                  const LightSample& light, const Vec3f& target, float time, CoverageKey key,
                  SampleRays* rays) {
  for (int passed = 0; passed < kMostPassed; ++passed) {
    const Ray ray = ray_to(light, from, target, time);
    if (!(dot(ray.direction, light.direction) > 0.0f)) return false;
    SurfaceHit hit;
    rays->shadow++;
    if (!scene.intersect(ray, key, &hit)) return false;
    if (roles.is_in_plate(hit.instance)) return true;
    SurfaceInteraction surface;
    scene.interaction(hit, time, &surface);
    from = offset_ray_origin(surface.position, surface.geometric_normal, surface.offset,
                             light.direction);
  }
  return false;
}

}  // namespace

// If a camera ray passes several catchers that are panes, the last one counts.
bool CatcherRecorder::goes_on(int lane) {
  const Path& path = b_.paths[lane];
  const SurfaceRole role = roles_->of(path.hit.instance);
  if (role == SurfaceRole::kSeen || path.events > 0) return true;
  const float through = luminance(path.throughput);
  const bool is_catcher = role == SurfaceRole::kCatcher && !caught_.empty();
  if (is_catcher) {
    catches_.emplace(lane) = {path.ray, path.hit, b_.depth + 1, through};
    if (!lanes_.contains(lane)) lanes_.add(lane);
  }
  if (role == SurfaceRole::kCatcher && !b_.settings.transparent) return true;
  if (is_catcher) caught_[size_t(lane)].hidden = through;
  b_.values[size_t(lane)].alpha = 1.0f - through;
  return false;
}

void CatcherRecorder::catch_light(int lane) {
  const Catch& at = catches_[lane];
  PixelSamples& samples = b_.samples;
  samples.resume_sample(lane);
  samples.start_slot(at.slot);
  caught_[size_t(lane)].catcher = at.weight;
  SurfaceInteraction surface;
  b_.scene.interaction(at.hit, at.ray.time, &surface);
  const SurfaceFrame frame = make_surface_frame(surface.geometric_normal, surface.shading_normal,
                                                surface.shading_normal, -at.ray.direction);
  const LightRequest request = {
      {surface.position, frame.shading.normal, false, at.ray.time},
      samples.get(surface_dim::kLightPick),
      {samples.get(surface_dim::kLightX), samples.get(surface_dim::kLightY)}};
  LightSample light;
  LightSample* const light_of_request = &light;
  b_.lights.sample({&request, 1}, &light_of_request, b_.batch.catcher_guide);
  if (light.kind == LightKind::kNone || !(light.pdf > 0.0f)) return;
  const float cosine = dot(light.direction, frame.shading.normal);
  if (!(cosine > 0.0f) || !(dot(light.direction, frame.geometric_normal) > 0.0f)) return;
  connect(lane, surface, light, at.weight * cosine / light.pdf);
}

void CatcherRecorder::connect(int lane, const SurfaceInteraction& surface, const LightSample& light,
                              float weight) {
  const Scene& scene = b_.scene;
  const float time = catches_[lane].ray.time;
  const Vec3f from = offset_ray_origin(surface.position, surface.geometric_normal, surface.offset,
                                       light.direction);
  Vec3f target;
  const Rgb arriving = emitted_radiance(scene, light, from, time, b_.samples, &target) * weight;
  if (is_black(arriving)) return;
  const CoverageKey key = coverage_key(scene, b_.samples);
  SampleRays* const rays = &b_.values[size_t(lane)].rays;
  Interior interior;
  float travelled;
  Rgb through = through_clear_faces(scene, from, light, target, time, key, &interior, &travelled,
                                    b_.samples, rays, nullptr);
  if (interior.solid()) through *= absorption(scene, interior.solid(), light.distance - travelled);
  CatcherSample& sample = caught_[size_t(lane)];
  sample.received = arriving * through;
  const bool in_plate =
      through != Rgb(1.0f) && plate_blocks(scene, *roles_, from, light, target, time, key, rays);
  sample.unshadowed = in_plate ? sample.received : arriving;
}

}  // namespace emberline
