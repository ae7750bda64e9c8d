// The state of a batch of paths: what the path loop, glass and the recorders share.
#pragma once

#include <cassert>
#include <cstdint>
#include <span>

#include "integrators/integrator.h"
#include "integrators/lane_array.h"
#include "integrators/path_media.h"
#include "integrators/sampled_light.h"
#include "integrators/surface_shading.h"
#include "renderer/lights/light_sampler.h"
#include "renderer/scene/scene.h"
#include "samplers/pixel_samples.h"

namespace emberline {

// Bounces between the camera and the light that a ray finds. Mirrors and smooth glass count only
// behind another surface.
enum class Bounces : uint8_t { kNone, kOne, kMore };
inline Bounces after_bounce(Bounces before, bool delta) {
  if (before == Bounces::kNone) return delta ? Bounces::kNone : Bounces::kOne;
  return Bounces::kMore;
}

// A path's vertex and how the ray that leaves it was sampled: weights the emission that the ray
// finds.
struct LastVertex {
  LightQuery query;
  float bsdf_pdf = 0.0f;
  int light_samples = 0;  // taken there; 0: emission found by the ray counts in full
};

struct Path {
  Ray ray;
  SurfaceHit hit;
  Rgb throughput = Rgb(1.0f);
  Rgb radiance = Rgb(0.0f);
  float eta_scale = 1.0f;  // radiance compression by refraction so far; for roulette only
  // Russian roulette for this ray: the probability to scatter where it hits, and to be traced.
  float survival = 1.0f, ray_survival = 1.0f;
  // Scattering events so far. Going straight through a smooth thin wall is none, so that a light
  // sample that sees through walls and a scattered ray agree on which paths there are.
  uint32_t events = 0;
  Bounces bounces = Bounces::kNone;
  LastVertex last;
  SampleRays rays;
};

// A light sample at a vertex.
struct Connection {
  LightSample light;
  Rgb scattered;  // BSDF x cosine towards it
  Rgb radiance;
  float bsdf_pdf;
  Vec3f from, target;
};

// Everything is indexed by lane, a sample's place in the batch. No path's value depends on which
// others are in its batch (law 1).
struct PathBatch {
  PathBatch(const IntegratorSettings& all_settings, const SampleBatch& sample_batch,
            PixelSamples& pixel_samples, std::span<SampleValue> sample_values)
      : settings(all_settings),
        batch(sample_batch),
        scene(sample_batch.scene),
        lights(scene.lights()),
        samples(pixel_samples),
        values(sample_values) {
    assert(batch.rays.size() <= size_t(kRayBatch));
  }
  bool may_scatter(const Path& path) const { return path.events < uint32_t(settings.max_depth); }

  bool intersect(const Ray& ray, SurfaceHit* hit) {
    return scene.intersect(ray, coverage_key(scene, samples), hit);
  }
  // Fetches a hit's triangle while the next ray is traced, and its vertices one ray later.
  // `*before` is the lane of the last call, -1 at first.
  void prefetch_hit(int lane, int* before) {
    scene.prefetch_triangle(paths[lane].hit);
    if (*before >= 0) scene.prefetch_vertices(paths[*before].hit);
    *before = lane;
  }
  void add_light(int lane, const Rgb& light) {
    Path& path = paths[lane];
    path.radiance = fma(path.throughput, light, path.radiance);
  }

  // Whether no surface is in the way of the lane's connection; multiplies its light by what
  // coverage lets through.
  bool is_visible(int lane, CoverageKey key) {
    Connection& c = connections[lane];
    Path& path = paths[lane];
    path.rays.shadow++;
    const float through = transmittance(scene, c.light, c.from, c.target, path.ray.time, key);
    c.scattered *= through;
    return through != 0.0f;
  }

  // Radiance of the environment along camera rays.
  void find_background(const LaneList& missed, Rgb* radiance) const;
  // Its radiance along the paths' rays, and the density with which an environment sample at the
  // vertex `from` of each ray takes the ray's direction.
  void find_environment(const LaneList& missed, const LastVertex* const* from, Rgb* radiance,
                        float* pdf);

  const IntegratorSettings& settings;
  const SampleBatch& batch;
  const Scene& scene;
  const LightSampler& lights;
  PixelSamples& samples;
  const std::span<SampleValue> values;

  uint32_t depth = 0;  // surfaces before the current one
  LaneList alive;
  LaneArray<Path> paths;
  LaneArray<ShadedPoint> points;
  LaneArray<TexelPlaces> texels;
  LaneArray<SurfaceBsdf> bsdfs;
  LaneArray<Connection> connections;
};

}  // namespace emberline
