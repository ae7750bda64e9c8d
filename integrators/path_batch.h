// The state of a batch of paths. The path loop, glass and the recorders share it.
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

// Number of bounces of a path so far. A bounce at a mirror or smooth glass counts only if the path
// has bounced at another kind of surface before.
enum class Bounces : uint8_t { kNone, kOne, kMore };
inline Bounces after_bounce(Bounces before, bool delta) {
  if (before == Bounces::kNone) return delta ? Bounces::kNone : Bounces::kOne;
  return Bounces::kMore;
}

struct GuideCell;  // renderer/scene/indirect_guide.h

// Describes a vertex of a path, and how the ray that leaves it was sampled. If the ray finds
// emission, this data gives the MIS weight of the emission.
struct LastVertex {
  LightQuery query;
  float bsdf_pdf = 0.0f;
  int light_samples = 0;  // taken at the vertex; if 0, emission found by the ray counts in full
};

struct Path {
  Ray ray;
  SurfaceHit hit;
  Rgb throughput = Rgb(1.0f);
  Rgb radiance = Rgb(0.0f);
  float eta_scale = 1.0f;  // radiance compression by refraction so far; used for roulette only
  // Roulette probabilities: `ray_survival` is the probability that this ray is traced; `survival`
  // is the probability that the ray is traced and the path is then scattered at the surface that
  // the ray hits.
  float survival = 1.0f, ray_survival = 1.0f;
  // The guide's cell at the current surface; null if paths are not guided here.
  const GuideCell* cell = nullptr;
  // Luminance that the guide expects at the first surface with a cell, times the throughput there;
  // -1 until then.
  float expected = -1.0f;
  // Scattering events so far. Going straight through a smooth thin wall is not counted. Light
  // samples also pass through such walls, so this rule gives light samples and scattered rays the
  // same depth limit.
  uint32_t events = 0;
  Bounces bounces = Bounces::kNone;
  LastVertex last;
  SampleRays rays;
};

// A light sample taken at a vertex, and the segment from the vertex to the light.
struct Connection {
  LightSample light;
  Rgb scattered;  // BSDF x cosine towards the light
  Rgb radiance;
  float bsdf_pdf;
  Vec3f from, target;
};

// Arrays are indexed by lane. A lane is the index of a sample in the batch. A path does not depend
// on the other paths of its batch (law 1).
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
  // Prefetches the triangle that this lane has hit. Also prefetches the vertices of the triangle
  // that the previous lane has hit; that triangle is in the cache by now. `*before` is the lane of
  // the previous call, or -1.
  void prefetch_hit(int lane, int* before) {
    scene.prefetch_triangle(paths[lane].hit);
    if (*before >= 0) scene.prefetch_vertices(paths[*before].hit);
    *before = lane;
  }
  void add_light(int lane, const Rgb& light) {
    Path& path = paths[lane];
    path.radiance = fma(path.throughput, light, path.radiance);
  }

  // Returns whether the lane's connection is unblocked. Multiplies the connection's light by the
  // transmittance of the partly covered surfaces on the way.
  bool is_visible(int lane, CoverageKey key) {
    Connection& c = connections[lane];
    Path& path = paths[lane];
    path.rays.shadow++;
    const float visibility = transmittance(scene, c.light, c.from, c.target, path.ray.time, key);
    c.scattered *= visibility;
    return visibility != 0.0f;
  }

  void eval_background(const LaneList& missed, Rgb* radiance) const;
  // Computes the environment's radiance along the paths' rays, and the pdf with which environment
  // sampling at the ray's vertex `from` would choose the ray's direction.
  void eval_environment(const LaneList& missed, const LastVertex* const* from, Rgb* radiance,
                        float* pdf);

  const IntegratorSettings& settings;
  const SampleBatch& batch;
  const Scene& scene;
  const LightSampler& lights;
  PixelSamples& samples;
  const std::span<SampleValue> values;

  uint32_t depth = 0;  // number of surfaces before the current one
  LaneList alive;
  LaneArray<Path> paths;
  LaneArray<ShadedPoint> points;
  LaneArray<TexelPositions> texels;
  LaneArray<SurfaceBsdf> bsdfs;
  LaneArray<Connection> connections;
};

}  // namespace emberline
