#include "integrators/recorders/catchers.h"

#include "integrators/path_media.h"
#include "integrators/sampled_light.h"

namespace emberline {
namespace {

// Upper limit for the number of surfaces between a catcher and a light. Real scenes have fewer.
constexpr int kMaxSurfaces = 10'000;

Ray make_shadow_ray(const LightSample& light, const Vec3f& from, const Vec3f& target, float time) {
  return light.distance == kInfinity ? Ray{from, light.direction, kInfinity, time}
                                     : Ray{from, target - from, 1.0f, time};
}

// Returns whether a surface of the compositor's plate (SurfaceRole) blocks the light.
bool is_blocked_by_plate(const Scene& scene, const SurfaceRoles& roles, Vec3f from,
                         const LightSample& light, const Vec3f& target, float time, CoverageKey key,
                         SampleRays* rays) {
  for (int passed = 0; passed < kMaxSurfaces; ++passed) {
    const Ray ray = make_shadow_ray(light, from, target, time);
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

// Records the hit of a camera path on a catcher. Returns false if the camera path ends here, at a
// holdout or a hidden catcher. If a camera ray passes through several catchers, the last one
// counts.
bool CatcherRecorder::continues_path(int lane) {
  const Path& path = b_.paths[lane];
  const SurfaceRole role = roles_->of(path.hit.instance);
  if (role == SurfaceRole::kOrdinary || path.events > 0) return true;
  const float transmittance = luminance(path.throughput);
  const bool is_catcher = role == SurfaceRole::kCatcher && !catcher_samples_.empty();
  if (is_catcher) {
    catcher_hits_.emplace(lane) = {path.ray, path.hit, b_.depth + 1, transmittance};
    if (!lanes_.contains(lane)) lanes_.add(lane);
  }
  if (role == SurfaceRole::kCatcher && !b_.settings.transparent) return true;
  if (is_catcher) catcher_samples_[size_t(lane)].hidden = transmittance;
  b_.values[size_t(lane)].alpha = 1.0f - transmittance;
  return false;
}

void CatcherRecorder::sample_catcher_light(int lane) {
  const CatcherHit& at = catcher_hits_[lane];
  PixelSamples& samples = b_.samples;
  samples.resume_sample(lane);
  samples.start_slot(at.slot);
  catcher_samples_[size_t(lane)].catcher = at.weight;
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
  const float time = catcher_hits_[lane].ray.time;
  const Vec3f from = offset_ray_origin(surface.position, surface.geometric_normal, surface.offset,
                                       light.direction);
  Vec3f target;
  const Rgb incident = emitted_radiance(scene, light, from, time, b_.samples, &target) * weight;
  if (is_black(incident)) return;
  const CoverageKey key = coverage_key(scene, b_.samples);
  SampleRays* const rays = &b_.values[size_t(lane)].rays;
  Interior interior;
  float medium_start;
  Rgb transmittance = clear_transmittance(scene, from, light, target, time, key, &interior,
                                          &medium_start, b_.samples, rays, nullptr);
  if (interior.medium())
    transmittance *= absorption(scene, interior.medium(), light.distance - medium_start);
  CatcherSample& sample = catcher_samples_[size_t(lane)];
  sample.received = incident * transmittance;
  const bool in_plate = transmittance != Rgb(1.0f) &&
                        is_blocked_by_plate(scene, *roles_, from, light, target, time, key, rays);
  sample.unshadowed = in_plate ? sample.received : incident;
}

}  // namespace emberline
