#include "integrators/path_batch.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <utility>

#include "integrators/sampled_light.h"
#include "integrators/recorders/catchers.h"
#include "renderer/core/hash.h"
#include "renderer/film/clamped_light.h"
#include "renderer/film/light_group_values.h"
#include "renderer/film/path_layers.h"
#include "renderer/lights/environment_guide.h"
#include "renderer/lights/environment_light.h"
#include "renderer/lights/light_guide.h"
#include "renderer/scene/light_groups.h"
#include "renderer/scene/solids.h"
#include "renderer/scene/surface_roles.h"

namespace emberline {
namespace {

// Russian roulette starts with this scattering event: short paths carry most of the light.
constexpr uint32_t kRouletteDepth = 2;
// A path that carries the share t goes on with the probability kRouletteScale sqrt(t): between none
// and all of it, as what a path will find is not known. Its ray is traced with kRayRouletteScale
// sqrt(t) already if it may meet an environment, which is often the brightest thing there is: the
// rest of the roulette spares the surface that it meets instead. Ours; figures:
// tests/bench/RESULTS.md.
constexpr float kRouletteScale = 1.5f;
constexpr float kRayRouletteScale = 4.0f;
// No path is ended with more than this probability, so no survivor is weighted by more than 20.
constexpr float kMinSurvival = 0.05f;

float survival(float scale, float root) { return std::clamp(scale * root, kMinSurvival, 1.0f); }

// Balance heuristic with one sample of a technique; of n samples, n times their density.
float balance(float pdf, float other_pdf) { return pdf / (pdf + other_pdf); }

}  // namespace

template <bool kGlass, bool kSplit>
PathBatch<kGlass, kSplit>::PathBatch(const IntegratorSettings& settings, const SampleBatch& batch,
                                     PixelSamples& samples)
    : settings_(settings),
      batch_(batch),
      scene_(batch.scene),
      lights_(scene_.lights()),
      sample_lights_(settings.light_samples > 0 && !lights_.empty()),
      samples_(samples) {
  assert(batch.rays.size() <= size_t(kRayBatch));
}

template <bool kGlass, bool kSplit>
void PathBatch<kGlass, kSplit>::trace(std::span<SampleValue> values) {
  find_first_hits(values);
  const LaneList hit = alive_;
  for (uint32_t depth = 0; !alive_.empty(); ++depth) {
    find_surfaces(depth, values);
    if (batch_.roles && (kGlass || depth == 0)) [[unlikely]]
      see_roles(values, depth);
    shade(depth, values);
    if (sample_lights_) sample_lights(depth);
    alive_.filter([&](int lane) { return scatter(depth, lane); });
    follow_rays(values);
  }
  for (const int lane : hit) {
    values[size_t(lane)].radiance = paths_[lane].radiance;
    values[size_t(lane)].rays = paths_[lane].rays;
    if (batch_.clamped) values[size_t(lane)].clamped = clamped_[lane];
  }
  if (!catcher_lanes_.empty()) [[unlikely]]
    catch_shadows(values);
}

template <bool kGlass, bool kSplit>
bool PathBatch<kGlass, kSplit>::intersect(const Ray& ray, SurfaceHit* hit) {
  return scene_.intersect(ray, coverage_key(scene_, samples_), hit);
}

// Memory of a path's hit comes while the next paths' rays are traced: first that of its triangle,
// then, when the one behind it has been traced, that of its vertices.
template <bool kGlass, bool kSplit>
void PathBatch<kGlass, kSplit>::prefetch_hit(int lane, int* before) {
  scene_.prefetch_triangle(paths_[lane].hit);
  if (*before >= 0) scene_.prefetch_vertices(paths_[*before].hit);
  *before = lane;
}

template <bool kGlass, bool kSplit>
void PathBatch<kGlass, kSplit>::find_first_hits(std::span<SampleValue> values) {
  LaneList missed;
  int before = -1;
  const int count = int(batch_.rays.size());
  for (int lane = 0; lane < count; ++lane) {
    if (batch_.nothing_ahead) {
      missed.add(lane);
      continue;
    }
    const Ray& ray = batch_.rays[size_t(lane)];
    SurfaceHit hit;
    samples_.start_sample(lane);
    if (!intersect(ray, &hit)) {
      missed.add(lane);
      continue;
    }
    Path& path = paths_.emplace(lane);
    path.ray = ray;
    path.hit = hit;
    if constexpr (kGlass) {
      if (batch_.interiors) path.interior = batch_.interiors[size_t(lane)];
    }
    prefetch_hit(lane, &before);
    if (batch_.clamped) clamped_.emplace(lane) = Rgb(0.0f);
    if (!batch_.features.empty()) feature_recorders_.emplace(lane);
    values[size_t(lane)].alpha = 1.0f;
    alive_.add(lane);
  }
  if (lights_.environment() && !settings_.transparent) see_background(missed, values);
  if (batch_.roles && !batch_.catcher_samples.empty()) [[unlikely]] {
    for (const int lane : missed) batch_.catcher_samples[size_t(lane)].background = 1.0f;
  }
}

template <bool kGlass, bool kSplit>
void PathBatch<kGlass, kSplit>::see_background(const LaneList& missed,
                                               std::span<SampleValue> values) {
  Vec3f directions[kRayBatch];
  Rgb radiance[kRayBatch];
  for (int i = 0; i < missed.size(); ++i) {
    directions[i] = batch_.rays[size_t(missed[i])].direction;
  }
  lights_.environment()->radiance({directions, size_t(missed.size())}, radiance);
  for (int i = 0; i < missed.size(); ++i) {
    values[size_t(missed[i])].radiance = radiance[i];
    values[size_t(missed[i])].alpha = 1.0f;
    if (!batch_.features.empty())
      batch_.features[size_t(missed[i])] = FeatureRecorder::background(radiance[i]);
    if constexpr (kSplit) {
      if (batch_.light_values)
        batch_.light_values->add(missed[i], group_of_environment(), Rgb(1.0f), radiance[i]);
      if (batch_.layer_values) {
        batch_.layer_values->add(missed[i], batch_.path_layers->place_of(PathLayer::kEnvironment),
                                 Rgb(1.0f), radiance[i]);
      }
    }
  }
}

// From hits to surface points. Ends the paths that leave the scene behind hidden faces.
template <bool kGlass, bool kSplit>
void PathBatch<kGlass, kSplit>::find_surfaces(uint32_t depth, std::span<SampleValue> values) {
  for (const int lane : alive_) {
    find_surface(scene_, paths_[lane].ray, paths_[lane].hit, &points_.emplace(lane));
  }
  if constexpr (kGlass) {
    if (!scene_.solids()) return;
    LaneList missed;
    const bool any_touch = scene_.solids()->touching_faces() > 0;
    alive_.filter([&](int lane) {
      const bool is_solid = points_[lane].surface.material->is_solid();
      if (!(is_solid || any_touch) || find_seen_face(depth, lane)) return true;
      missed.add(lane);
      return false;
    });
    if (!missed.empty()) leave_scene(&missed, values);
  }
}

// Another face in the place of the one that was hit.
template <bool kGlass, bool kSplit>
void PathBatch<kGlass, kSplit>::find_face(const Ray& ray, const SurfaceHit& face, float offset,
                                          int lane) {
  SurfaceHit& hit = paths_[lane].hit;
  hit = {hit.t, face.u, face.v, face.instance, face.primitive};
  find_surface(scene_, ray, hit, &points_[lane]);
  points_[lane].surface.offset = offset;
}

// Follows the ray through hidden faces of solids, to a surface that it sees; false: there is none.
template <bool kGlass, bool kSplit>
bool PathBatch<kGlass, kSplit>::find_seen_face(uint32_t depth, int lane) {
  if constexpr (kGlass) {
    Path& path = paths_[lane];
    ShadedPoint& point = points_[lane];
    Ray ray = path.ray;
    for (uint32_t faces = 0; point.surface.material->is_solid(); ++faces) {
      if (faces == 0 && scene_.has_coverage()) samples_.resume_sample(lane);
      const SolidCrossing crossing(scene_, point.surface, path.hit, ray,
                                   coverage_key(scene_, samples_));
      point.surface.offset = crossing.offset();
      // A back face met outside of all solids: the camera stands in an open one.
      if (crossing.back() && path.interior.empty()) {
        path.interior.enter(scene_, path.hit.instance);
      }
      if (const SurfaceHit* surface = crossing.surface()) {
        find_face(ray, *surface, crossing.offset(), lane);
        return true;
      }
      Interior& far = far_.emplace(lane) = path.interior;
      if (!crossing.cross(scene_, &far) && batch_.optics) batch_.optics->solids_forgotten++;
      if (!is_hidden(scene_, crossing, path.interior, far, path.hit.instance)) {
        const SurfaceHit& seen = crossing.seen_face(scene_, path.interior, far);
        if (seen.instance != path.hit.instance) find_face(ray, seen, crossing.offset(), lane);
        return true;
      }
      if (faces == kMostWalls) {
        if (batch_.optics) batch_.optics->rays_ended_at_walls++;
        path.throughput = Rgb(0.0f);
        return false;
      }
      if (far.solid() != path.interior.solid()) {
        absorb(depth, point, &path);
        path.scattering.absorbed_to = way_so_far(depth, point, path);
      }
      path.interior = far;
      ray.origin = point.spawn_origin(ray.direction);
      path.rays.scatter++;
      if (!intersect(ray, &path.hit)) {
        if (!batch_.features.empty()) [[unlikely]]
          feature_recorders_[lane].see_background(Rgb(0.0f), &batch_.features[size_t(lane)]);
        return false;
      }
      find_surface(scene_, ray, path.hit, &point);
      path.hit.t = (point.surface.position - path.ray.origin).length();
    }
    // A solid's face may lie in this one.
    if (scene_.solids()->may_touch(path.hit.instance, path.hit.primitive)) {
      point.surface.offset *= SolidCrossing::kReach;
    }
  }
  return true;
}

// From point to point: hit.t starts at the offset origin, which in a thin slab counts.
template <bool kGlass, bool kSplit>
float PathBatch<kGlass, kSplit>::way_so_far(uint32_t depth, const ShadedPoint& point,
                                            const Path& path) const {
  return depth == 0 ? path.hit.t : (point.surface.position - path.last.query.point).length();
}

// Multiplies the throughput by the absorption on the way to the point.
template <bool kGlass, bool kSplit>
void PathBatch<kGlass, kSplit>::absorb(uint32_t depth, const ShadedPoint& point, Path* path) const {
  if constexpr (kGlass) {
    if (!path->interior.solid()) return;
    const float distance = way_so_far(depth, point, *path) - path->scattering.absorbed_to;
    path->throughput *= absorption(scene_, path->interior.solid(), distance);
  }
}

// Where a path goes that leaves the lane's point along `wi`, local.
template <bool kGlass, bool kSplit>
const Interior& PathBatch<kGlass, kSplit>::interior_along(const Vec3f& wi, int lane) {
  if constexpr (kGlass) {
    const bool passes = wi.z < 0.0f && points_[lane].surface.material->is_solid();
    return passes ? far_[lane] : paths_[lane].interior;
  } else {
    return far_[lane];  // not called
  }
}

// Scattering events before the path's vertex, of which `depth` surfaces came before. To go straight
// through a smooth thin wall is none: so a light sample that looks through walls agrees with the
// scattered ray that comes the same way on which paths there are.
template <bool kGlass, bool kSplit>
uint32_t PathBatch<kGlass, kSplit>::events_before(uint32_t depth, const Path& path) const {
  if constexpr (kGlass) return path.scattering.events;
  return depth;
}

template <bool kGlass, bool kSplit>
bool PathBatch<kGlass, kSplit>::may_scatter(uint32_t depth, const Path& path) const {
  return events_before(depth, path) < uint32_t(settings_.max_depth);
}

// The vertex whose light sample may find what the ray under way finds.
template <bool kGlass, bool kSplit>
const typename PathBatch<kGlass, kSplit>::LastVertex& PathBatch<kGlass, kSplit>::sampled_from(
    const Path& path) const {
  if constexpr (kGlass) {
    return path.scattering.vertex;
  } else {
    return path.last;
  }
}

// From surface points to materials and BSDFs; adds what the surfaces emit. Ends the paths that may
// not scatter.
template <bool kGlass, bool kSplit>
void PathBatch<kGlass, kSplit>::shade(uint32_t depth, std::span<SampleValue> values) {
  for (const int lane : alive_) {
    samples_.resume_sample(lane);
    samples_.start_slot(depth + 1);
    find_texels(samples_.get(surface_dim::kTexture), points_[lane], &texels_.emplace(lane));
  }
  for (const int lane : alive_) {
    find_material(texels_[lane], &points_[lane]);
    if constexpr (kGlass) {
      Path& path = paths_[lane];
      if (points_[lane].surface.material->is_solid()) {
        samples_.resume_sample(lane);
        if (is_flat_solid(scene_, path.hit)) {
          path.scattering.wavelength.bends = false;
          make_wall(path.interior, points_[lane]);
        } else {
          set_relative_ior(path.interior, far_[lane], samples_, path.scattering.wavelength,
                           points_[lane]);
        }
      } else {
        path.scattering.wavelength.bends = false;
      }
    }
  }
  for (const int lane : alive_) {
    bsdfs_.emplace_result(lane, [&] { return points_[lane].bsdf(); });
  }
  alive_.filter([&](int lane) {
    Path& path = paths_[lane];
    const ShadedPoint& point = points_[lane];
    if constexpr (kGlass) absorb(depth, point, &path);
    if (depth == 0) {
      fill_first_hit(batch_, path.hit, point, path.ray.time, bsdfs_[lane].albedo(),
                     &values[size_t(lane)].first_hit);
    }
    if (!batch_.features.empty()) [[unlikely]] {
      feature_recorders_[lane].see(batch_, path.ray, path.hit.t, point, bsdfs_[lane],
                                   path.throughput, &batch_.features[size_t(lane)]);
    }
    const Rgb emitted = surface_emission(path, point);
    if (!is_black(emitted)) {
      add_light(lane, path.way, Found::kSurface, group_of_material(point.surface.material_index),
                emitted);
    }
    path.last.query = {point.surface.position, point.frame.shading.normal,
                       kGlass && bsdfs_[lane].transmits_non_delta(), path.ray.time};
    if (point.surface.material->unlit()) return false;
    return may_scatter(depth, path) || (kGlass && is_smooth_wall(scene_, path.hit));
  });
}

template <bool kGlass, bool kSplit>
Rgb PathBatch<kGlass, kSplit>::surface_emission(const Path& path, const ShadedPoint& point) const {
  Rgb emission = point.material.emission;
  if (is_black(emission)) return emission;
  if (point.surface.material->emission_changes()) {
    emission *= point.surface.material->emission_share(path.ray.time);
  }
  const LastVertex& from = sampled_from(path);
  if (from.light_samples == 0 || is_black(emission)) return emission;
  const uint32_t emitter = scene_.emitter_index(path.hit.instance, path.hit.primitive);
  if (emitter == Scene::kNoEmitter) return emission;
  float distance = path.hit.t;
  if constexpr (kGlass) {
    if (path.scattering.walls > 0) distance = (point.surface.position - from.query.point).length();
  }
  const float light_pdf =
      lights_.pdf_triangle(from.query, emitter, path.ray.direction, distance, batch_.guide);
  return emission * balance(from.bsdf_pdf, float(from.light_samples) * light_pdf);
}

// A surface that is seen, also in a mirror or through smooth glass, takes several, all others one:
// what is beyond a bounce is noisier by the bounce than by the choice of a light. A surface under
// a smooth coat and what is seen in that coat draw the same further numbers.
template <bool kGlass, bool kSplit>
int PathBatch<kGlass, kSplit>::light_samples_at(const Path& path) const {
  return path.way == Way::kSeen ? settings_.light_samples : 1;
}

// Sampled lights of each vertex, weighted against the BSDF sample that follows.
template <bool kGlass, bool kSplit>
void PathBatch<kGlass, kSplit>::sample_lights(uint32_t depth) {
  LaneList sampled, again;
  LightRequest requests[kRayBatch];
  for (const int lane : alive_) {
    LastVertex& vertex = paths_[lane].last;
    vertex.light_samples = 0;
    if (!bsdfs_[lane].has_non_delta()) continue;
    vertex.light_samples = light_samples_at(paths_[lane]);
    if (kGlass && !may_scatter(depth, paths_[lane])) continue;
    samples_.resume_sample(lane);
    requests[sampled.size()] = {
        vertex.query,
        samples_.get(surface_dim::kLightPick),
        {samples_.get(surface_dim::kLightX), samples_.get(surface_dim::kLightY)}};
    sampled.add(lane);
    if (vertex.light_samples > 1) again.add(lane);
  }
  connect_lanes(sampled, requests);
  for (int i = 1; !again.empty() && i < settings_.light_samples; ++i) {
    for (int k = 0; k < again.size(); ++k) {
      const int lane = again[k];
      samples_.resume_sample(lane);
      requests[k] = {paths_[lane].last.query,
                     samples_.beside(i - 1, surface_dim::kLightPick),
                     {samples_.beside(i - 1, surface_dim::kLightX),
                      samples_.beside(i - 1, surface_dim::kLightY)}};
    }
    connect_lanes(again, requests);
  }
}

template <bool kGlass, bool kSplit>
void PathBatch<kGlass, kSplit>::connect_lanes(LaneList lanes, const LightRequest* requests) {
  LightSample* samples[kRayBatch] = {};
  for (int i = 0; i < lanes.size(); ++i) samples[i] = &connections_.emplace(lanes[i]).light;
  lights_.sample({requests, size_t(lanes.size())}, samples, batch_.guide);
  lanes.filter([this](int lane) { return connect(lane); });
  for (const int lane : lanes) add_connection(lane);
}

// Sets up the light that arrives if nothing is in the way; false: none.
template <bool kGlass, bool kSplit>
bool PathBatch<kGlass, kSplit>::connect(int lane) {
  const ShadedPoint& point = points_[lane];
  Connection& c = connections_[lane];
  if (c.light.kind == LightKind::kNone || !(c.light.pdf > 0.0f)) return false;
  const Vec3f wi = point.frame.shading.to_local(c.light.direction);
  c.scattered = bsdfs_[lane].eval_and_pdf(wi, &c.bsdf_pdf);
  if (is_black(c.scattered)) return false;
  if constexpr (kGlass) {
    c.interior = &interior_along(wi, lane);
    const PathWavelength& wavelength = paths_[lane].scattering.wavelength;
    if (wavelength.bends && wi.z < 0.0f) c.scattered *= wavelength.weight;
  }
  c.from = point.spawn_origin(c.light.direction);
  samples_.resume_sample(lane);
  c.radiance =
      emitted_radiance(scene_, c.light, c.from, paths_[lane].ray.time, samples_, &c.target);
  return !is_black(c.radiance);
}

// Whether a sampled light is not hidden; multiplies `scattered` by what the way lets through.
template <bool kGlass, bool kSplit>
bool PathBatch<kGlass, kSplit>::passes(int lane, Rgb* scattered) {
  const Connection& c = connections_[lane];
  Path& path = paths_[lane];
  const float time = path.ray.time;
  samples_.resume_sample(lane);
  const CoverageKey key = coverage_key(scene_, samples_);
  if constexpr (kGlass) {
    // A way through coverage is one of chance there, and an expectation in the other case.
    const Solids* solids = scene_.solids();
    const bool may_meet_hidden_faces =
        (!c.interior->empty() && (!scene_.has_coverage() || solids->any_are_near())) ||
        (solids && solids->any_let_through());
    if (scene_.has_smooth_walls() || may_meet_hidden_faces) {
      Interior interior = *c.interior;
      float travelled;
      *scattered *= through_clear_faces(scene_, c.from, c.light, c.target, time, key, &interior,
                                        &travelled, samples_, &path.rays, batch_.optics);
      const bool arrives = !is_black(*scattered);
      if (arrives) {
        *scattered *= absorption(scene_, interior.solid(), c.light.distance - travelled);
      }
      count_light_sample(lane, key, arrives);
      return arrives;
    }
  }
  path.rays.shadow++;
  const bool infinite = c.light.distance == kInfinity;
  const float through = infinite
                            ? scene_.transmittance_to_infinity(c.from, c.light.direction, time, key)
                            : scene_.transmittance(c.from, c.target, time, key);
  if constexpr (kGlass) count_light_sample(lane, key, through != 0.0f);
  if (through == 0.0f) return false;
  if (!infinite && scene_.behind_flush_emitter(c.from, c.light, time, key)) return false;
  *scattered *= through;
  if constexpr (kGlass) *scattered *= absorption(scene_, c.interior->solid(), c.light.distance);
  return true;
}

// Light that only its samples find is lost behind smooth solid glass, which bends it. Which samples
// are looked at is a function of the sample alone.
template <bool kGlass, bool kSplit>
void PathBatch<kGlass, kSplit>::count_light_sample(int lane, CoverageKey key, bool arrives) {
  const Connection& c = connections_[lane];
  if (!c.light.delta || !scene_.has_smooth_solids() || !batch_.optics) return;
  if (hash32(std::bit_cast<uint32_t>(c.from.x + c.from.y)) >> 28 != 0) return;
  batch_.optics->point_light_samples++;
  if (!arrives &&
      blocked_by_glass_alone(scene_, c.from, c.light, c.target, paths_[lane].ray.time, key)) {
    batch_.optics->blocked_by_glass++;
  }
}

template <bool kGlass, bool kSplit>
void PathBatch<kGlass, kSplit>::add_connection(int lane) {
  Connection& c = connections_[lane];
  Path& path = paths_[lane];
  if (!passes(lane, &c.scattered)) return;
  if (!batch_.features.empty()) [[unlikely]]
    feature_recorders_[lane].see_light(&batch_.features[size_t(lane)]);
  // balance / (n pdf) = 1 / (n pdf + other); a point-like light has no other technique.
  const float light_pdf = float(path.last.light_samples) * c.light.pdf;
  const Rgb arriving =
      c.scattered * c.radiance / (c.light.delta ? light_pdf : light_pdf + c.bsdf_pdf);
  const Way way = path.way == Way::kSeen ? Way::kDirect : Way::kIndirect;
  add_light(lane, way, Found::kSampled, group_of(c.light), arriving);
}

template <bool kGlass, bool kSplit>
void PathBatch<kGlass, kSplit>::add_light(int lane, Way way, Found found, uint32_t group,
                                          const Rgb& light) {
  Path& path = paths_[lane];
  Rgb arriving = light;
  if (batch_.clamped && way == Way::kIndirect) [[unlikely]]
    arriving = clamp(lane, group, light);
  path.radiance = fma(path.throughput, arriving, path.radiance);
  if constexpr (kSplit) {
    if (batch_.light_values) batch_.light_values->add(lane, group, path.throughput, arriving);
    if (batch_.layer_values) add_to_layers(lane, found, arriving);
  }
}

// The kind of event at the path's vertex for a continuation along wi, in local space.
template <bool kGlass, bool kSplit>
typename PathBatch<kGlass, kSplit>::FirstEvent PathBatch<kGlass, kSplit>::event_along(
    int lane, const Vec3f& wi, bool transmitted, bool delta) {
  if (transmitted) return {FirstEvent::Kind::kTransmitted};
  FirstEvent event{FirstEvent::Kind::kReflected};
  if (delta) return event;
  const Rgb all = bsdfs_[lane].eval(wi), diffuse = bsdfs_[lane].eval_diffuse(wi);
  for (int c = 0; c < 3; ++c) {
    event.diffuse[c] = all[c] > 0.0f ? std::min(1.0f, diffuse[c] / all[c]) : 0.0f;
  }
  return event;
}

template <bool kGlass, bool kSplit>
void PathBatch<kGlass, kSplit>::follow_event(int lane, const BsdfSample& next) {
  if constexpr (kSplit) {
    FirstEvent& first = paths_[lane].first;
    const bool straight = next.delta && next.transmitted && points_[lane].material.bsdf.thin_walled;
    if (first.kind == FirstEvent::Kind::kNone) {
      first = event_along(lane, next.wi, next.transmitted, next.delta);
    } else if (!straight) {
      first.again = true;
    }
  }
}

template <bool kGlass, bool kSplit>
void PathBatch<kGlass, kSplit>::add_to_layers(int lane, Found found, const Rgb& light) {
  using Kind = typename FirstEvent::Kind;
  const Path& path = paths_[lane];
  const auto add = [&](PathLayer layer, const Rgb& part) {
    batch_.layer_values->add(lane, batch_.path_layers->place_of(layer), path.throughput, part);
  };
  FirstEvent first;
  if constexpr (kSplit) first = path.first;
  if (found == Found::kSampled) {
    if (first.kind == Kind::kNone) {
      const Vec3f& direction = connections_[lane].light.direction;
      const Vec3f wi = points_[lane].frame.shading.to_local(direction);
      first = event_along(lane, wi, wi.z < 0.0f, false);
    } else {
      first.again = true;
    }
  }
  switch (first.kind) {
    case Kind::kNone:
      return add(found == Found::kSurface ? PathLayer::kEmission : PathLayer::kEnvironment, light);
    case Kind::kTransmitted:
      return add(PathLayer::kTransmission, light);
    case Kind::kReflected:
      const Rgb diffuse = light * first.diffuse;
      add(first.again ? PathLayer::kIndirect : PathLayer::kDirect, diffuse);
      add(PathLayer::kReflection, light - diffuse);
  }
}

// Light that is not finite stays so: it is to be seen that there was some.
template <bool kGlass, bool kSplit>
[[gnu::noinline, gnu::cold]] Rgb PathBatch<kGlass, kSplit>::clamp(int lane, uint32_t group,
                                                                  const Rgb& light) {
  const Rgb& throughput = paths_[lane].throughput;
  const Rgb contribution = throughput * light;
  const float most = max_component(contribution);
  if (!(most > settings_.clamp_indirect) || !is_finite(contribution)) return light;
  const Rgb clamped = light * (settings_.clamp_indirect / most);
  const Rgb taken = throughput * (light - clamped);
  clamped_[lane] += taken;
  batch_.clamped->take(group, taken);
  return clamped;
}

template <bool kGlass, bool kSplit>
BsdfSample PathBatch<kGlass, kSplit>::sample_bsdf(uint32_t depth, int lane) {
  if constexpr (kGlass) {
    if (!may_scatter(depth, paths_[lane])) {  // it can only go straight on
      BsdfSample on;
      on.weight = bsdfs_[lane].straight_through();
      on.delta = on.transmitted = on.valid = true;
      return on;
    }
  }
  return bsdfs_[lane].sample(samples_.get(surface_dim::kLobe), {samples_.get(surface_dim::kBsdfX),
                                                                samples_.get(surface_dim::kBsdfY)});
}

// Chooses the path's next ray; false: it ends here.
template <bool kGlass, bool kSplit>
bool PathBatch<kGlass, kSplit>::scatter(uint32_t depth, int lane) {
  Path& path = paths_[lane];
  const ShadedPoint& point = points_[lane];
  samples_.resume_sample(lane);
  const BsdfSample next = sample_bsdf(depth, lane);
  if (!next.valid) return false;
  path.throughput *= next.weight;
  if (is_black(path.throughput)) return false;
  if (next.delta) path.last.light_samples = 0;
  path.last.bsdf_pdf = next.pdf;
  if constexpr (kGlass) {
    path.eta_scale *= next.eta_scale;
    if (next.transmitted && point.surface.material->is_solid()) path.interior = far_[lane];
    PathWavelength& wavelength = path.scattering.wavelength;
    if (wavelength.bends && next.transmitted) {
      path.throughput *= std::exchange(wavelength.weight, Rgb(1.0f));
    }
  }

  if (events_before(depth, path) + 1 >= kRouletteDepth) {
    const float level = max_component(path.throughput) * path.eta_scale;
    const float root = std::sqrt(level);
    const float path_survival = survival(kRouletteScale, root);
    const float ray_survival =
        lights_.environment() ? survival(kRayRouletteScale, root) : path_survival;
    if (samples_.get(surface_dim::kRoulette) >= ray_survival) return false;
    path.throughput *= 1.0f / ray_survival;
    path.survival = path_survival;
    path.ray_survival = ray_survival;
  }
  return leave_along(next, lane);
}

// False: through too many walls.
template <bool kGlass, bool kSplit>
bool PathBatch<kGlass, kSplit>::leave_along(const BsdfSample& next, int lane) {
  Path& path = paths_[lane];
  const ShadedPoint& point = points_[lane];
  Vec3f direction = point.frame.shading.to_world(next.wi);
  if constexpr (kSplit) {
    if (batch_.layer_values) follow_event(lane, next);
  }
  if constexpr (kGlass) {
    Scattering& scattering = path.scattering;
    if (next.delta && next.transmitted && point.material.bsdf.thin_walled) {
      direction = path.ray.direction;
      if (++scattering.walls > kMostWalls) {
        if (batch_.optics) batch_.optics->rays_ended_at_walls++;
        return false;
      }
    } else {
      scattering.vertex = path.last;
      scattering.events++;
      scattering.walls = 0;
      path.way = longer(path.way, next.delta);
    }
  } else {
    path.way = longer(path.way, next.delta);
  }
  if constexpr (kGlass) path.scattering.absorbed_to = 0.0f;
  path.ray = {point.spawn_origin(direction), direction, kInfinity, path.ray.time};
  return true;
}

// The rest of Russian roulette, for a ray that has met a surface; what shines is looked at in any
// case. The number is the one that let the ray be traced.
template <bool kGlass, bool kSplit>
bool PathBatch<kGlass, kSplit>::survives_hit(Path* path) {
  if (path->survival == path->ray_survival) return true;
  const Material& material = scene_.material_of(path->hit.instance);
  if (material.is_emissive() || material.unlit()) return true;
  if (samples_.get(surface_dim::kRoulette) >= path->survival) return false;
  path->throughput *= path->ray_survival / path->survival;
  return true;
}

template <bool kGlass, bool kSplit>
void PathBatch<kGlass, kSplit>::follow_rays(std::span<SampleValue> values) {
  LaneList missed;
  int before = -1;
  alive_.filter([&](int lane) {
    Path& path = paths_[lane];
    path.rays.scatter++;
    samples_.resume_sample(lane);
    if (intersect(path.ray, &path.hit)) {
      if (!survives_hit(&path)) return false;
      prefetch_hit(lane, &before);
      return true;
    }
    missed.add(lane);
    if (!batch_.features.empty()) [[unlikely]]
      feature_recorders_[lane].see_background(Rgb(0.0f), &batch_.features[size_t(lane)]);
    return false;
  });
  if (!missed.empty()) leave_scene(&missed, values);
}

template <bool kGlass, bool kSplit>
void PathBatch<kGlass, kSplit>::leave_scene(LaneList* missed, std::span<SampleValue> values) {
  if (kGlass) see_nothing(missed, values);
  if (lights_.environment() && !missed->empty()) see_environment(*missed);
}

template <bool kGlass, bool kSplit>
bool PathBatch<kGlass, kSplit>::is_straight(const Path& path) const {
  if constexpr (kGlass) return path.scattering.events == 0;
  return true;
}

// Where nothing is behind the panes that the camera sees, they are as opaque as what they hold
// back. Light that they tint has three such numbers; alpha is one.
template <bool kGlass, bool kSplit>
void PathBatch<kGlass, kSplit>::see_nothing(LaneList* missed, std::span<SampleValue> values) {
  const bool visible = lights_.environment() && !settings_.transparent;
  if (visible && batch_.catcher_samples.empty()) return;
  missed->filter([&](int lane) {
    const Path& path = paths_[lane];
    if (!is_straight(path)) return true;
    const float through = luminance(path.throughput);
    if (!batch_.catcher_samples.empty()) batch_.catcher_samples[size_t(lane)].background = through;
    if (!visible) values[size_t(lane)].alpha = 1.0f - through;
    return visible;
  });
}

// Ends the paths of camera rays that have met a holdout or an invisible catcher. If a camera ray
// passes several catchers that are panes, the last one counts.
template <bool kGlass, bool kSplit>
void PathBatch<kGlass, kSplit>::see_roles(std::span<SampleValue> values, uint32_t depth) {
  alive_.filter([&](int lane) {
    const Path& path = paths_[lane];
    const SurfaceRole role = batch_.roles->of(path.hit.instance);
    if (role == SurfaceRole::kSeen || !is_straight(path)) return true;
    const float through = luminance(path.throughput);
    const bool is_catcher = role == SurfaceRole::kCatcher && !batch_.catcher_samples.empty();
    if (is_catcher) {
      catches_.emplace(lane) = {path.ray, path.hit, depth + 1, through};
      if (!catcher_lanes_.contains(lane)) catcher_lanes_.add(lane);
    }
    if (role == SurfaceRole::kCatcher && !settings_.transparent) return true;
    if (is_catcher) batch_.catcher_samples[size_t(lane)].hidden = through;
    values[size_t(lane)].alpha = 1.0f - through;
    return false;
  });
}

// When the paths are done: none of their numbers are others for it.
template <bool kGlass, bool kSplit>
void PathBatch<kGlass, kSplit>::catch_shadows(std::span<SampleValue> values) {
  if (lights_.empty()) return;
  for (const int lane : catcher_lanes_) {
    const Catch& at = catches_[lane];
    samples_.resume_sample(lane);
    samples_.start_slot(at.slot);
    catch_light(scene_, *batch_.roles, at.ray, at.hit, at.weight, batch_.catcher_guide, samples_,
                &values[size_t(lane)].rays, &batch_.catcher_samples[size_t(lane)]);
  }
}

template <bool kGlass, bool kSplit>
void PathBatch<kGlass, kSplit>::see_environment(const LaneList& missed) {
  Vec3f directions[kRayBatch];
  Rgb radiance[kRayBatch];
  float pdf[kRayBatch];
  for (int i = 0; i < missed.size(); ++i) directions[i] = paths_[missed[i]].ray.direction;
  if (batch_.guide && batch_.guide->environment) [[unlikely]] {
    const EnvironmentGuide& guide = *batch_.guide->environment;
    int regions[kRayBatch];
    for (int i = 0; i < missed.size(); ++i) {
      const LastVertex& from = sampled_from(paths_[missed[i]]);
      const bool guided = from.light_samples > 0 && !from.query.both_sides;
      regions[i] =
          guided ? guide.region_of(from.query.point, from.query.normal) : SkyRegions::kNone;
    }
    const auto count = size_t(missed.size());
    guide.radiance_and_pdf({directions, count}, {regions, count}, radiance, pdf);
  } else {
    lights_.environment()->radiance_and_pdf({directions, size_t(missed.size())}, radiance, pdf);
  }
  for (int i = 0; i < missed.size(); ++i) {
    Path& path = paths_[missed[i]];
    if (!batch_.features.empty()) [[unlikely]]
      feature_recorders_[missed[i]].see_background(path.throughput * radiance[i],
                                                   &batch_.features[size_t(missed[i])]);
    const LastVertex& from = sampled_from(path);
    if (from.light_samples > 0) {
      const float light_pdf = float(from.light_samples) * pdf[i] *
                              lights_.environment_probability(from.query, batch_.guide);
      radiance[i] *= balance(from.bsdf_pdf, light_pdf);
    }
    add_light(missed[i], path.way, Found::kEnvironment, group_of_environment(), radiance[i]);
  }
}

// The group of a light; 0 without groups.
template <bool kGlass, bool kSplit>
uint32_t PathBatch<kGlass, kSplit>::group_of(const LightSample& light) const {
  if (!kSplit || !batch_.light_groups) return 0;
  if (light.kind == LightKind::kPoint) return batch_.light_groups->of_point(light.index);
  if (light.kind == LightKind::kEnvironment) return group_of_environment();
  const EmissiveTriangle& triangle = lights_.triangles()[light.index];
  return group_of_material(scene_.material_index_of(triangle.instance));
}

template <bool kGlass, bool kSplit>
uint32_t PathBatch<kGlass, kSplit>::group_of_material(uint32_t material) const {
  return kSplit && batch_.light_groups ? batch_.light_groups->of_material(material) : 0;
}

template <bool kGlass, bool kSplit>
uint32_t PathBatch<kGlass, kSplit>::group_of_environment() const {
  return kSplit && batch_.light_groups ? batch_.light_groups->of_environment() : 0;
}

template class PathBatch<false, false>;
template class PathBatch<true, false>;
template class PathBatch<false, true>;
template class PathBatch<true, true>;

}  // namespace emberline
