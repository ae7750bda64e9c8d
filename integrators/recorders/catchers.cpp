#include "integrators/recorders/catchers.h"

#include "integrators/path_media.h"
#include "integrators/sampled_light.h"
#include "integrators/surface_shading.h"
#include "renderer/scene/surface_roles.h"

namespace emberline {
namespace {

// Surfaces in a row that a way to a light may pass: ours, more than a scene has.
constexpr int kMostPassed = 10'000;

Ray ray_to(const LightSample& light, const Vec3f& from, const Vec3f& target, float time) {
  return light.distance == kInfinity ? Ray{from, light.direction, kInfinity, time}
                                     : Ray{from, target - from, 1.0f, time};
}

// Whether something of the plate is on the way to a light.
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

void catch_light(const Scene& scene, const SurfaceRoles& roles, const Ray& ray,
                 const SurfaceHit& hit, float weight, const LightGuide* guide,
                 PixelSamples& samples, SampleRays* rays, CatcherSample* sample) {
  sample->catcher = weight;
  SurfaceInteraction surface;
  scene.interaction(hit, ray.time, &surface);
  const SurfaceFrame frame = make_surface_frame(surface.geometric_normal, surface.shading_normal,
                                                surface.shading_normal, -ray.direction);
  const LightRequest request = {
      {surface.position, frame.shading.normal, false, ray.time},
      samples.get(surface_dim::kLightPick),
      {samples.get(surface_dim::kLightX), samples.get(surface_dim::kLightY)}};
  LightSample light;
  LightSample* const light_of_request = &light;
  scene.lights().sample({&request, 1}, &light_of_request, guide);
  if (light.kind == LightKind::kNone || !(light.pdf > 0.0f)) return;
  const float cosine = dot(light.direction, frame.shading.normal);
  if (!(cosine > 0.0f) || !(dot(light.direction, frame.geometric_normal) > 0.0f)) return;
  const Vec3f from = offset_ray_origin(surface.position, surface.geometric_normal, surface.offset,
                                       light.direction);
  Vec3f target;
  const Rgb arriving = emitted_radiance(scene, light, from, ray.time, samples, &target) *
                       (weight * cosine / light.pdf);
  if (is_black(arriving)) return;
  const CoverageKey key = coverage_key(scene, samples);
  Interior interior;
  float travelled;
  Rgb through = through_clear_faces(scene, from, light, target, ray.time, key, &interior,
                                    &travelled, samples, rays, nullptr);
  if (interior.solid()) through *= absorption(scene, interior.solid(), light.distance - travelled);
  sample->received = arriving * through;
  const bool in_plate =
      through != Rgb(1.0f) && plate_blocks(scene, roles, from, light, target, ray.time, key, rays);
  sample->unshadowed = in_plate ? sample->received : arriving;
}

}  // namespace emberline
