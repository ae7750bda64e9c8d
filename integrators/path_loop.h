// The path loop: intersect, shade, add emitted light, sample a light, sample the BSDF, roulette.
//
// The paths of a batch advance together. Each stage runs over all lanes before the next one begins,
// so that one path's cache misses and divisions overlap with the arithmetic of others. Compared
// with tracing one path at a time, this is 1.08 times as fast on FlightHelmet and 1.05 times as
// fast on a Cornell box.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "integrators/path_batch.h"
#include "integrators/path_media.h"
#include "integrators/sampled_light.h"
#include "renderer/scene/indirect_guide.h"

namespace emberline {

// `Glass` is PathGlass (path_glass.h), or NoGlass if no material of the scene transmits light.
// `Recorders` is AllRecorders (recorders/all.h), or NoRecorder if the batch asks for radiance and
// alpha only. The hooks of NoGlass and NoRecorder compile to nothing.
template <class Glass, class Recorders>
class PathLoop : private PathBatch {
 public:
  using PathBatch::PathBatch;

  void trace() {
    find_first_hits();
    const LaneList hit = alive;
    for (; !alive.empty(); ++depth) {
      find_surfaces();
      shade();
      if (batch.indirect_guide) guide_paths();
      add_emission();
      if (sample_lights_) sample_lights();
      alive.filter([this](int lane) { return scatter(lane); });
      trace_rays();
    }
    for (const int lane : hit) {
      values[size_t(lane)].radiance = paths[lane].radiance;
      values[size_t(lane)].rays = paths[lane].rays;
    }
    recorders_.paths_ended(hit);
  }

 private:
  // Number of the scattering event at which Russian roulette starts. Shorter paths are spared,
  // since they carry most of the light.
  static constexpr uint32_t kRouletteDepth = 2;
  // A path with throughput t continues with probability kRouletteScale sqrt(t). The square root is
  // a compromise between 1 and t, because the light that the path will find is unknown. The
  // environment is often the brightest light. So a ray that may reach it is traced with the higher
  // probability kRayRouletteScale sqrt(t), and the roulette is completed at the surface that the
  // ray hits. Both scales are our choice; measurements are in tests/bench/results.
  static constexpr float kRouletteScale = 1.5f;
  static constexpr float kRayRouletteScale = 4.0f;
  // With a guide, the expected light is known. A path that is expected to add the fraction f of its
  // pixel's light continues with probability kLightRouletteScale f, and at least with probability
  // kGuidedRouletteScale sqrt(t). (The optimum is in proportion to f if relative variance and cost
  // are the same everywhere; Rath et al. 2022, "EARS: Efficiency-Aware Russian Roulette and
  // Splitting".)
  static constexpr float kLightRouletteScale = 3.0f;
  static constexpr float kGuidedRouletteScale = 0.7f;
  // Limits the probability of ending a path to 95 %, so that a survivor's weight grows by a factor
  // of at most 20.
  static constexpr float kMinSurvival = 0.05f;
  static constexpr float kTiny = std::numeric_limits<float>::min();  // for light that may be 0

  static float survival(float scale, float root) {
    return std::clamp(scale * root, kMinSurvival, 1.0f);
  }
  // The balance heuristic. If a technique takes n samples, pass n times its pdf.
  static float balance_heuristic(float pdf, float other_pdf) { return pdf / (pdf + other_pdf); }

  // ---- intersect

  void find_first_hits() {
    LaneList missed;
    int before = -1;
    for (int lane = 0; lane < int(batch.rays.size()); ++lane) {
      if (batch.all_rays_miss || !find_first_hit(lane)) {
        missed.add(lane);
        continue;
      }
      prefetch_hit(lane, &before);
      glass_.begin(lane);
      recorders_.begin(lane);
      values[size_t(lane)].alpha = 1.0f;
      alive.add(lane);
    }
    recorders_.camera_missed(missed);
    if (lights.environment() && !settings.transparent) add_background(missed);
  }

  bool find_first_hit(int lane) {
    const Ray& ray = batch.rays[size_t(lane)];
    SurfaceHit hit;
    samples.start_sample(lane);
    if (!intersect(ray, &hit)) return false;
    Path& path = paths.emplace(lane);
    path.ray = ray;
    path.hit = hit;
    return true;
  }

  void add_background(const LaneList& missed) {
    Rgb radiance[kRayBatch];
    eval_background(missed, radiance);
    for (int i = 0; i < missed.size(); ++i) {
      values[size_t(missed[i])].radiance = radiance[i];
      values[size_t(missed[i])].alpha = 1.0f;
      recorders_.background(missed[i], radiance[i]);
    }
  }

  void trace_rays() {
    LaneList missed;
    int before = -1;
    alive.filter([&](int lane) {
      Path& path = paths[lane];
      path.rays.scatter++;
      samples.resume_sample(lane);
      if (intersect(path.ray, &path.hit)) {
        if (!survives_hit_roulette(&path)) return false;
        prefetch_hit(lane, &before);
        return true;
      }
      missed.add(lane);
      return false;
    });
    if (!missed.empty()) leave_scene(&missed);
  }

  // Plays the second part of the roulette, at the surface that the ray hits. Uses the same random
  // number as the first part (survives_roulette()). Emissive surfaces are always shaded.
  bool survives_hit_roulette(Path* path) {
    if (path->survival == path->ray_survival) return true;
    const Material& material = scene.material_of(path->hit.instance);
    if (material.is_emissive() || material.unlit()) return true;
    if (samples.get(surface_dim::kRoulette) >= path->survival) return false;
    path->throughput *= path->ray_survival / path->survival;
    return true;
  }

  // ---- shade

  void find_surfaces() {
    for (const int lane : alive) {
      find_surface(scene, paths[lane].ray, paths[lane].hit, &points.emplace(lane));
    }
    LaneList missed;
    glass_.skip_hidden_faces(&missed);
    if (!missed.empty()) leave_scene(&missed);
    recorders_.surfaces_hit();
  }

  // Evaluates the materials and BSDFs of the surface points.
  void shade() {
    for (const int lane : alive) {
      samples.resume_sample(lane);
      samples.start_slot(depth + 1);
      find_texels(samples.get(surface_dim::kTexture), points[lane], &texels.emplace(lane));
    }
    for (const int lane : alive) {
      find_material(texels[lane], &points[lane]);
      glass_.update_ior(lane);
    }
    for (const int lane : alive) {
      bsdfs.emplace_result(lane, [&] { return points[lane].bsdf(); });
    }
  }

  void guide_paths() {
    for (const int lane : alive) {
      Path& path = paths[lane];
      SurfaceBsdf& bsdf = bsdfs[lane];
      path.cell = nullptr;
      if (!bsdf.can_be_guided()) continue;
      const ShadedPoint& point = points[lane];
      path.cell = batch.indirect_guide->find(point.surface.position, point.frame.shading.normal);
      if (!path.cell) continue;
      bsdf.set_guide(&path.cell->directions);
      if (path.expected < 0.0f) {
        path.expected = luminance(path.throughput) *
                        (luminance(point.material.emission) +
                         luminance(bsdf.albedo()) * (path.cell->direct + path.cell->indirect));
      }
    }
  }

  // ---- emitted light

  // Adds the light that surfaces emit, and ends the paths that may not scatter any more.
  void add_emission() {
    alive.filter([this](int lane) {
      Path& path = paths[lane];
      const ShadedPoint& point = points[lane];
      glass_.absorb(lane);
      recorders_.shaded(lane);
      const Rgb emitted = surface_emission(lane);
      if (!is_black(emitted)) add_light(lane, recorders_.emitted(lane, emitted));
      path.last.query = {point.surface.position, point.frame.shading.normal,
                         Glass::transmits(bsdfs[lane]), path.ray.time};
      if (point.surface.material->unlit()) return false;
      return may_scatter(path) || glass_.is_clear_wall(lane);
    });
  }

  Rgb surface_emission(int lane) {
    const Path& path = paths[lane];
    const ShadedPoint& point = points[lane];
    Rgb emission = point.material.emission;
    if (is_black(emission)) return emission;
    if (point.surface.material->is_emission_animated()) {
      emission *= point.surface.material->emission_scale(path.ray.time);
    }
    const LastVertex& from = glass_.scattering_vertex(lane);
    if (from.light_samples == 0 || is_black(emission)) return emission;
    const uint32_t emitter = scene.emitter_index(path.hit.instance, path.hit.primitive);
    if (emitter == Scene::kNoEmitter) return emission;
    const float distance = glass_.distance_from_vertex(lane);
    const float light_pdf = lights.pdf_triangle(from.query, emitter, distance, batch.guide);
    return emission * balance_heuristic(from.bsdf_pdf, float(from.light_samples) * light_pdf);
  }

  void leave_scene(LaneList* missed) {
    for (const int lane : *missed) recorders_.missed(lane);
    glass_.hide_background(missed);
    if (lights.environment() && !missed->empty()) add_environment(*missed);
  }

  void add_environment(const LaneList& missed) {
    const LastVertex* from[kRayBatch];
    Rgb radiance[kRayBatch];
    float pdf[kRayBatch];
    for (int i = 0; i < missed.size(); ++i) {
      from[i] = &glass_.scattering_vertex(missed[i]);
    }
    eval_environment(missed, from, radiance, pdf);
    for (int i = 0; i < missed.size(); ++i) {
      Rgb light = radiance[i];
      if (from[i]->light_samples > 0) {
        const float light_pdf = float(from[i]->light_samples) * pdf[i] *
                                lights.environment_probability(from[i]->query, batch.guide);
        light *= balance_heuristic(from[i]->bsdf_pdf, light_pdf);
      }
      add_light(missed[i], recorders_.environment(missed[i], radiance[i], light));
    }
  }

  // ---- sample a light

  // Surfaces that are visible directly, in mirrors or through smooth glass take several samples.
  // Other surfaces take one, since the bounce that led to them adds more noise than the choice of a
  // light does.
  void sample_lights() {
    LaneList sampled;
    for (const int lane : alive) {
      Path& path = paths[lane];
      path.last.light_samples = 0;
      if (!bsdfs[lane].has_non_delta()) continue;
      path.last.light_samples = path.bounces == Bounces::kNone ? settings.light_samples : 1;
      if (!Glass::kEnabled || may_scatter(path)) sampled.add(lane);
    }
    for (int i = 0; !sampled.empty(); ++i) {
      connect_lanes(sampled, i);
      sampled.filter([&](int lane) { return paths[lane].last.light_samples > i + 1; });
    }
  }

  // Takes the i-th light sample of each lane. For i > 0, the random numbers do not depend on the
  // surface. A path may therefore use the same numbers at two surfaces: for example, under a smooth
  // coat and at the surface that the coat reflects.
  void connect_lanes(LaneList lanes, int i) {
    LightRequest requests[kRayBatch];
    LightSample* out[kRayBatch] = {};
    for (int k = 0; k < lanes.size(); ++k) {
      samples.resume_sample(lanes[k]);
      const auto number = [&](int dimension) {
        return i == 0 ? samples.get(dimension) : samples.get_auxiliary(i - 1, dimension);
      };
      requests[k] = {paths[lanes[k]].last.query,
                     number(surface_dim::kLightPick),
                     {number(surface_dim::kLightX), number(surface_dim::kLightY)}};
      out[k] = &connections.emplace(lanes[k]).light;
    }
    lights.sample({requests, size_t(lanes.size())}, out, batch.guide);
    lanes.filter([this](int lane) { return connect(lane); });
    for (const int lane : lanes) add_connection(lane);
  }

  // Computes the light that arrives if nothing blocks it. Returns false if no light can arrive.
  bool connect(int lane) {
    const ShadedPoint& point = points[lane];
    Connection& c = connections[lane];
    if (c.light.kind == LightKind::kNone || !(c.light.pdf > 0.0f)) return false;
    const Vec3f wi = point.frame.shading.to_local(c.light.direction);
    c.scattered = bsdfs[lane].eval_and_pdf(wi, &c.bsdf_pdf);
    if (is_black(c.scattered)) return false;
    glass_.connect(lane, wi);
    c.from = point.spawn_origin(c.light.direction);
    samples.resume_sample(lane);
    c.radiance = emitted_radiance(scene, c.light, c.from, paths[lane].ray.time, samples, &c.target);
    return !is_black(c.radiance);
  }

  void add_connection(int lane) {
    const Connection& c = connections[lane];
    samples.resume_sample(lane);
    const CoverageKey key = coverage_key(scene, samples);
    if (!glass_.arrives(lane, key)) return;
    // The MIS weight divided by the density is balance_heuristic / (n pdf) = 1 / (n pdf + other).
    // `other` is 0 for point-like lights, since only light sampling finds them.
    const float light_pdf = float(paths[lane].last.light_samples) * c.light.pdf;
    const Rgb light =
        c.scattered * c.radiance / (c.light.delta ? light_pdf : light_pdf + c.bsdf_pdf);
    add_light(lane, recorders_.connected(lane, light));
  }

  // ---- sample the BSDF, roulette

  BsdfSample sample_bsdf(int lane) {
    const SurfaceBsdf& bsdf = bsdfs[lane];
    if (Glass::kEnabled && !may_scatter(paths[lane])) return straight_sample(bsdf);
    return bsdf.sample(samples.get(surface_dim::kLobe),
                       {samples.get(surface_dim::kBsdfX), samples.get(surface_dim::kBsdfY)});
  }

  // Samples the path's next ray. Returns false if the path ends here.
  bool scatter(int lane) {
    Path& path = paths[lane];
    samples.resume_sample(lane);
    const BsdfSample next = sample_bsdf(lane);
    if (!next.valid) return false;
    const Rgb before = path.throughput;
    path.throughput *= next.weight;
    if (is_black(path.throughput)) return false;
    if (next.delta) path.last.light_samples = 0;
    path.last.bsdf_pdf = next.pdf;
    glass_.scatter(lane, next);
    return survives_roulette(lane, before) && leave(lane, next);
  }

  // `before` is the throughput before the surface scattered the path.
  bool survives_roulette(int lane, const Rgb& before) {
    Path* const path = &paths[lane];
    if (path->events + 1 < kRouletteDepth) return true;
    const float root = std::sqrt(max_component(path->throughput) * path->eta_scale);
    if (path->cell) {
      const float expected =
          luminance(before) * luminance(bsdfs[lane].albedo()) * path->cell->indirect;
      path->survival =
          std::max(survival(kGuidedRouletteScale, root),
                   survival(kLightRouletteScale, expected / std::max(path->expected, kTiny)));
      path->ray_survival = path->survival;
    } else {
      path->survival = survival(kRouletteScale, root);
      path->ray_survival =
          lights.environment() ? survival(kRayRouletteScale, root) : path->survival;
    }
    if (samples.get(surface_dim::kRoulette) >= path->ray_survival) return false;
    path->throughput *= 1.0f / path->ray_survival;
    return true;
  }

  bool leave(int lane, const BsdfSample& next) {
    Path& path = paths[lane];
    const ShadedPoint& point = points[lane];
    recorders_.scattered(lane, next);
    Vec3f direction = path.ray.direction;
    if (glass_.is_straight_passage(lane, next)) {
      if (!glass_.count_wall(lane)) return false;
    } else {
      direction = point.frame.shading.to_world(next.wi);
      path.events++;
      path.bounces = after_bounce(path.bounces, next.delta);
      glass_.leave(lane);
    }
    path.ray = {point.spawn_origin(direction), direction, kInfinity, path.ray.time};
    return true;
  }

  const bool sample_lights_ = settings.light_samples > 0 && !lights.empty();
  [[no_unique_address]] Glass glass_{*this};
  [[no_unique_address]] Recorders recorders_{*this};
};

}  // namespace emberline
