#include "integrators/path_media.h"

#include "renderer/shading/lobes/wavelength.h"
#include "samplers/pixel_samples.h"

namespace emberline {

void set_relative_ior(const Interior& near, const Interior& far, PixelSamples& samples,
                      PathWavelength& wavelength, ShadedPoint& point) {
  wavelength.is_dispersive = false;
  const bool back = point.frame.back_facing;
  const Material* const inner = (back ? near : far).medium();
  const Material* const outer = (back ? far : near).medium();
  if (!inner) return;
  wavelength.is_dispersive = inner->dispersion() > 0.0f || (outer && outer->dispersion() > 0.0f);
  if (wavelength.is_dispersive && wavelength.nanometres == 0.0f) {
    const SampledWavelength sampled = sample_wavelength(samples.extra());
    wavelength = {sampled.nanometres, sampled.weight, true};
  }
  const auto ior_of = [&](const Material& medium) {
    return medium.dispersion() > 0.0f
               ? ior_at(medium.ior(), medium.dispersion(), wavelength.nanometres)
               : medium.ior();
  };
  BsdfParameters& bsdf = point.material.bsdf;
  bsdf.ior = ior_of(*inner);
  // A solid with an index of 0 reflects everything, whatever surrounds it.
  if (!outer || !(bsdf.ior > 0.0f) || !(outer->ior() > 0.0f)) return;
  // The lobe expects an index of at least 1. `inside` then means that the path is on the denser
  // side.
  bsdf.ior /= ior_of(*outer);
  if (bsdf.ior < 1.0f) {
    bsdf.ior = 1.0f / bsdf.ior;
    bsdf.inside = !bsdf.inside;
  }
}

void make_thin_walled(const Interior& around, ShadedPoint& point) {
  BsdfParameters& bsdf = point.material.bsdf;
  bsdf.thin_walled = true;
  bsdf.inside = false;
  bsdf.ior = point.surface.material->ior();
  const Material* const outer = around.medium();
  if (!outer || !(bsdf.ior > 0.0f) || !(outer->ior() > 0.0f)) return;
  bsdf.ior = std::max(bsdf.ior / outer->ior(), outer->ior() / bsdf.ior);
}

namespace {

// A shadow ray that restarts behind each surface that it passes. At each restart, it is aimed at
// the light again. As in Scene::transmittance(), t = 1 is exactly at the target.
class ShadowRay {
 public:
  ShadowRay(const LightSample& light, const Vec3f& target, float time)
      : light_(light), target_(target), time_(time) {}
  Ray from(const Vec3f& origin) const {
    return light_.distance == kInfinity ? Ray{origin, light_.direction, kInfinity, time_}
                                        : Ray{origin, target_ - origin, 1.0f, time_};
  }
  // Returns whether the ray has reached or passed the light.
  bool is_past_light(const Ray& ray) const {
    return !(dot(ray.direction, light_.direction) > 0.0f);
  }

 private:
  const LightSample& light_;
  const Vec3f target_;
  const float time_;
};

// Returns the straight-through transmittance of the hit surface. Sets `*next_origin` to the point
// at which the connection continues.
Rgb wall_transmittance(const Scene& scene, const Vec3f& direction, float time,
                       const SurfaceHit& hit, const Interior& around, float u_texture,
                       Vec3f* next_origin) {
  ShadedPoint point = shade(scene, Ray{Vec3f(0.0f), direction, kInfinity, time}, hit, u_texture);
  if (is_flat_solid(scene, hit)) make_thin_walled(around, point);
  *next_origin = point.spawn_origin(direction);
  return point.bsdf().straight_transmittance();
}

// Follows a connection through hidden faces of solids.
class HiddenFaceWalk {
 public:
  HiddenFaceWalk(const Scene& scene, const Vec3f& from, Interior* interior, float* medium_start)
      : scene_(scene), start_(from), interior_(interior), medium_start_(medium_start) {
    *medium_start = 0.0f;
  }
  // Returns whether the hit face of a solid may be a hidden face.
  bool may_be_hidden(const SurfaceHit& hit) const {
    return scene_.solids() &&
           (!interior_->empty() || scene_.solids()->transmits_straight(hit.instance));
  }
  // Returns whether the face is hidden. If so, attenuates `*transmittance` and sets `*next_origin`
  // to the point at which the connection continues.
  bool cross(const Ray& ray, const Vec3f& direction, const SurfaceHit& hit,
             CoverageKey coverage_key, Rgb* transmittance, Vec3f* next_origin) {
    SurfaceInteraction surface;
    scene_.interaction(hit, ray.time, &surface);
    const SolidCrossing crossing(scene_, surface, hit, ray, coverage_key);
    Interior far = *interior_;
    crossing.cross(scene_, &far);
    if (crossing.surface() || !is_hidden(scene_, crossing, *interior_, far, hit.instance)) {
      return false;
    }
    if (far.medium() != interior_->medium()) {
      const float here = (surface.position - start_).length();
      *transmittance *= absorption(scene_, interior_->medium(), here - *medium_start_);
      *medium_start_ = here;
    }
    *interior_ = far;
    *next_origin =
        offset_ray_origin(surface.position, surface.geometric_normal, crossing.offset(), direction);
    return true;
  }

 private:
  const Scene& scene_;
  const Vec3f start_;
  Interior* const interior_;
  float* const medium_start_;
};

}  // namespace

Rgb clear_transmittance(const Scene& scene, Vec3f from, const LightSample& light,
                        const Vec3f& target, float time, CoverageKey coverage_key,
                        Interior* interior, float* medium_start, PixelSamples& samples,
                        SampleRays* rays, OpticsCounters* counters) {
  const ShadowRay shadow_ray(light, target, time);
  HiddenFaceWalk hidden(scene, from, interior, medium_start);
  Rgb transmittance(1.0f);
  for (uint32_t faces = 0; faces <= kMaxWalls; ++faces) {
    const Ray ray = shadow_ray.from(from);
    if (shadow_ray.is_past_light(ray)) return transmittance;
    SurfaceHit hit;
    rays->shadow++;
    // The whole connection uses one coverage key. This is correct, since no part of the connection
    // is traced twice.
    if (!scene.intersect(ray, coverage_key, &hit)) {
      return scene.is_behind_flush_emitter(from, light, time, coverage_key) ? Rgb(0.0f)
                                                                            : transmittance;
    }
    const Material& material = scene.material_of(hit.instance);
    if (is_smooth_wall(scene, hit)) {
      transmittance *=
          wall_transmittance(scene, light.direction, time, hit, *interior, samples.extra(), &from);
      if (is_black(transmittance)) return transmittance;
    } else if (!material.is_solid() || !hidden.may_be_hidden(hit) ||
               !hidden.cross(ray, light.direction, hit, coverage_key, &transmittance, &from)) {
      return Rgb(0.0f);
    }
  }
  if (counters) counters->rays_ended_at_panes++;
  return Rgb(0.0f);
}

bool is_blocked_only_by_glass(const Scene& scene, Vec3f from, const LightSample& light,
                              const Vec3f& target, float time, CoverageKey coverage_key) {
  constexpr int kMaxFaces = 64;  // a light behind more faces counts as blocked by something else
  const ShadowRay shadow_ray(light, target, time);
  bool met_solid = false;
  for (int faces = 0; faces < kMaxFaces; ++faces) {
    const Ray ray = shadow_ray.from(from);
    SurfaceHit hit;
    if (shadow_ray.is_past_light(ray) || !scene.intersect(ray, coverage_key, &hit))
      return met_solid;
    const Material& material = scene.material_of(hit.instance);
    if (!material.is_smooth_solid() && !material.is_smooth_wall()) return false;
    met_solid = met_solid || material.is_smooth_solid();
    SurfaceInteraction surface;
    scene.interaction(hit, time, &surface);
    from = offset_ray_origin(surface.position, surface.geometric_normal, surface.offset,
                             light.direction);
  }
  return false;
}

}  // namespace emberline
