#include "integrators/path_integrator.h"

#include <algorithm>

#include "integrators/surface_shading.h"
#include "renderer/lights/environment_light.h"

namespace emberline {
namespace {

// Russian roulette starts after this many scattering events: short paths carry most of the light.
constexpr uint32_t kRouletteDepth = 3;
// No path is ended with more than this probability, so no survivor is weighted by more than 20.
constexpr float kMinSurvival = 0.05f;

// Balance heuristic with one sample of each technique.
float balance(float pdf, float other_pdf) { return pdf / (pdf + other_pdf); }

// How the ray under way was sampled, for the weight of emission it runs into.
struct LastVertex {
  LightQuery query;
  float bsdf_pdf = 0.0f;
  bool light_sampled = false;  // false: emission found by the ray counts in full
};

uint32_t coverage_key(const Scene& scene, PixelSamples& samples) {
  return scene.has_coverage() ? samples.extra_bits() : 0u;
}

Rgb environment_radiance(const LightSampler& lights, const Ray& ray, const LastVertex& last) {
  const EnvironmentLight* environment = lights.environment();
  if (!environment) return Rgb(0.0f);
  if (!last.light_sampled) return environment->radiance(ray.direction);
  float light_pdf = 0.0f;
  const Rgb radiance = environment->radiance_and_pdf(ray.direction, &light_pdf);
  light_pdf *= lights.environment_probability(last.query);
  return radiance * balance(last.bsdf_pdf, light_pdf);
}

Rgb surface_emission(const Scene& scene, const ShadedPoint& point, const Ray& ray,
                     const SurfaceHit& hit, const LastVertex& last) {
  const Rgb& emission = point.material.emission;
  if (!last.light_sampled || is_black(emission)) return emission;
  const uint32_t emitter = scene.emitter_index(hit.instance, hit.primitive);
  if (emitter == Scene::kNoEmitter) return emission;
  const float light_pdf = scene.lights().pdf_triangle(last.query, emitter, ray.direction, hit.t);
  return emission * balance(last.bsdf_pdf, light_pdf);
}

// Radiance that a sampled light sends towards the point, and whether anything blocks the way is
// the caller's question; `target` is where that question's ray ends.
Rgb emitted_radiance(const Scene& scene, const LightSample& light, const Vec3f& from,
                     PixelSamples& samples, Vec3f* target) {
  if (light.kind != LightKind::kTriangle) {
    *target = light.position;
    return light.radiance;
  }
  const EmissiveTriangle& triangle = scene.lights().triangles()[light.index];
  *target = offset_ray_origin(light.position, light.emitter_normal,
                              scene.surface_offset(triangle.instance, triangle.primitive),
                              from - light.position);
  const SurfaceAttributes attributes = scene.emitter_attributes(triangle, light.barycentric);
  const Material& material = scene.material_of(triangle.instance);
  // A number of its own: the emitter's texel must not depend on which texel this vertex took.
  const float u_texture = material.needs_uv() ? samples.extra() : 0.0f;
  Rgb radiance = material.emission(attributes, u_texture);
  // A path sees the emitter only where it covers; the light sample must agree on average.
  // Decided apart from the emission, as a ray's coverage is: a card that is bright where it is
  // clear shows the product of the means.
  if (material.alpha_mode() != AlphaMode::kOpaque) {
    radiance *= material.coverage(attributes, samples.extra());
  }
  return radiance;
}

// A solid's material, if the point lies on one.
const Material* solid_material(const ShadedPoint& point) {
  const Material* material = point.surface.material;
  return material->has_transmission() && !point.material.bsdf.thin_walled ? material : nullptr;
}

// What lies on the other side of the point's surface, seen from a path that is inside `solid`.
const Material* medium_behind(const ShadedPoint& point, const Material* solid) {
  const Material* own = solid_material(point);
  if (!own) return solid;  // a thin wall, or no passage at all
  return point.frame.back_facing ? nullptr : own;
}

// Absorption of a solid over an internal distance; a light at infinity is taken to be beyond the
// scene, whose own size bounds what can lie in between.
Rgb absorption(const Scene& scene, const Material* solid, float distance) {
  if (!solid) return Rgb(1.0f);
  const float within = std::min(distance, 2.0f * scene.radius());
  return beer_transmittance(solid->attenuation(), float(double(within) / scene.scale()));
}

// What smooth thin walls let straight through on the way to a light of no extent. No ray that is
// scattered can find such a light, so nothing is counted twice. `distance` may be infinite.
Rgb through_thin_walls(const Scene& scene, Vec3f from, const Vec3f& direction, const Vec3f& target,
                       bool infinite, PixelSamples& samples, RayCounters& counters) {
  constexpr int kMostWalls = 64;  // ours: more panes in a row than a picture can show
  Rgb through(1.0f);
  for (int wall = 0; wall < kMostWalls; ++wall) {
    const float distance = infinite ? kInfinity : dot(target - from, direction);
    if (!(distance > 0.0f)) return through;
    SurfaceHit hit;
    const Ray ray{from, direction, distance};
    counters.shadow++;
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

}  // namespace

void PathIntegrator::estimate(const SampleBatch& batch, PixelSamples& samples,
                              std::span<SampleValue> values, RayCounters& counters) const {
  for (size_t i = 0; i < batch.rays.size(); ++i) {
    samples.start_sample(batch.first_sample + uint32_t(i));
    values[i] = trace(batch, batch.rays[i], samples, counters);
  }
}

SampleValue PathIntegrator::trace(const SampleBatch& batch, Ray ray, PixelSamples& samples,
                                  RayCounters& counters) const {
  const Scene& scene = batch.scene;
  const LightSampler& lights = scene.lights();
  const bool sample_lights = settings_.light_sampling && !lights.empty();

  SampleValue value;
  Rgb throughput(1.0f);
  float eta_scale = 1.0f;           // radiance compression by refraction so far; for roulette only
  const Material* solid = nullptr;  // what the path is inside of
  LastVertex last;
  counters.camera++;
  for (uint32_t depth = 0;; ++depth) {
    SurfaceHit hit;
    if (!scene.intersect(ray, coverage_key(scene, samples), &hit)) {
      const bool hidden = depth == 0 && settings_.transparent;
      if (!hidden && lights.environment()) {
        value.radiance += throughput * environment_radiance(lights, ray, last);
        if (depth == 0) value.alpha = 1.0f;
      }
      break;
    }
    samples.start_slot(depth + 1);
    const ShadedPoint point = shade(scene, ray, hit, samples.get(surface_dim::kTexture));
    // A back face met outside of any solid means that the camera stands in one.
    const Material* const crossed =
        solid || !point.frame.back_facing ? solid : solid_material(point);
    if (crossed) {
      // From point to point: hit.t starts at the offset origin, which in a thin slab counts.
      const float distance =
          depth == 0 ? hit.t : (point.surface.position - last.query.point).length();
      throughput *= absorption(scene, crossed, distance);
    }
    const SurfaceBsdf bsdf = point.bsdf();
    if (depth == 0) {
      value.alpha = 1.0f;
      fill_first_hit(batch, point, bsdf.albedo(), &value.first_hit);
    }
    value.radiance += throughput * surface_emission(scene, point, ray, hit, last);
    if (point.surface.material->unlit() || depth >= uint32_t(settings_.max_depth)) break;

    last.query = {point.surface.position, point.frame.shading.normal, bsdf.transmits_non_delta()};
    last.light_sampled = sample_lights && bsdf.has_non_delta();
    if (last.light_sampled) {
      value.radiance +=
          throughput * direct_light(scene, point, bsdf, last.query, crossed, samples, counters);
    }

    const BsdfSample next =
        bsdf.sample(samples.get(surface_dim::kLobe),
                    {samples.get(surface_dim::kBsdfX), samples.get(surface_dim::kBsdfY)});
    if (!next.valid) break;
    throughput *= next.weight;
    if (is_black(throughput)) break;
    if (next.delta) last.light_sampled = false;
    last.bsdf_pdf = next.pdf;
    eta_scale *= next.eta_scale;
    solid = next.transmitted ? medium_behind(point, crossed) : crossed;

    if (depth + 1 >= kRouletteDepth) {
      const float survival = std::clamp(max_component(throughput) * eta_scale, kMinSurvival, 1.0f);
      if (samples.get(surface_dim::kRoulette) >= survival) break;
      throughput *= 1.0f / survival;
    }
    const Vec3f direction = point.frame.shading.to_world(next.wi);
    ray = {point.spawn_origin(direction), direction};
    counters.scatter++;
  }
  return value;
}

Rgb PathIntegrator::direct_light(const Scene& scene, const ShadedPoint& point,
                                 const SurfaceBsdf& bsdf, const LightQuery& query,
                                 const Material* solid, PixelSamples& samples,
                                 RayCounters& counters) {
  const LightSample light =
      scene.lights().sample(query, samples.get(surface_dim::kLightPick),
                            {samples.get(surface_dim::kLightX), samples.get(surface_dim::kLightY)});
  if (light.kind == LightKind::kNone || !(light.pdf > 0.0f)) return Rgb(0.0f);
  float bsdf_pdf = 0.0f;
  const Vec3f wi = point.frame.shading.to_local(light.direction);
  Rgb scattered = bsdf.eval_and_pdf(wi, &bsdf_pdf);
  if (is_black(scattered)) return Rgb(0.0f);
  const Vec3f from = point.spawn_origin(light.direction);
  Vec3f target;
  const Rgb radiance = emitted_radiance(scene, light, from, samples, &target);
  if (is_black(radiance)) return Rgb(0.0f);
  counters.shadow++;
  const uint32_t key = coverage_key(scene, samples);
  const bool infinite = light.distance == kInfinity;
  const bool visible = infinite ? scene.visible_to_infinity(from, light.direction, key)
                                : scene.visible(from, target, key);
  if (!visible) {
    if (!light.delta || !scene.has_transmission()) return Rgb(0.0f);
    scattered *=
        through_thin_walls(scene, from, light.direction, target, infinite, samples, counters);
  }
  scattered *= absorption(scene, wi.z < 0.0f ? medium_behind(point, solid) : solid, light.distance);
  // balance / pdf = 1 / (pdf + other); a point-like light has no other technique.
  return scattered * radiance / (light.delta ? light.pdf : light.pdf + bsdf_pdf);
}

}  // namespace emberline
