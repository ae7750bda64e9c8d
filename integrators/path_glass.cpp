#include "integrators/path_glass.h"

#include <bit>

#include "renderer/core/hash.h"
#include "renderer/scene/solids.h"

namespace emberline {

void PathGlass::skip_hidden_faces(LaneList* missed) {
  if (!b_.scene.solids()) return;
  const bool any_touch = b_.scene.solids()->touching_faces() > 0;
  b_.alive.filter([&](int lane) {
    const bool is_solid = b_.points[lane].surface.material->is_solid();
    if (!(is_solid || any_touch) || find_seen_face(lane)) return true;
    missed->add(lane);
    return false;
  });
}

// Replaces the hit by another face.
void PathGlass::find_face(const Ray& ray, const SurfaceHit& face, float offset, int lane) {
  SurfaceHit& hit = b_.paths[lane].hit;
  hit = {hit.t, face.u, face.v, face.instance, face.primitive};
  find_surface(b_.scene, ray, hit, &b_.points[lane]);
  b_.points[lane].surface.offset = offset;
}

// Follows the ray through hidden faces of solids to a visible surface. False: there is none.
bool PathGlass::find_seen_face(int lane) {
  Path& path = b_.paths[lane];
  ShadedPoint& point = b_.points[lane];
  Ray ray = path.ray;
  for (uint32_t faces = 0; point.surface.material->is_solid(); ++faces) {
    if (faces == 0 && b_.scene.has_coverage()) b_.samples.resume_sample(lane);
    const SolidCrossing crossing(b_.scene, point.surface, path.hit, ray,
                                 coverage_key(b_.scene, b_.samples));
    if (is_seen(crossing, ray, lane)) return true;
    if (faces == kMostWalls) {
      if (b_.batch.optics) b_.batch.optics->rays_ended_at_walls++;
      path.throughput = Rgb(0.0f);
      return false;
    }
    if (!next_face(&ray, lane)) return false;
  }
  // A face of a solid may coincide with this surface.
  if (b_.scene.solids()->may_touch(path.hit.instance, path.hit.primitive)) {
    point.surface.offset *= SolidCrossing::kReach;
  }
  return true;
}

// Whether the path sees the faces that it crosses, or a surface that lies in them. If so, the hit
// becomes the face or surface that scatters.
bool PathGlass::is_seen(const SolidCrossing& crossing, const Ray& ray, int lane) {
  const SurfaceHit& hit = b_.paths[lane].hit;
  Interior& near = near_[lane];
  b_.points[lane].surface.offset = crossing.offset();
  // A back face met outside of all solids means that the camera is inside an open one.
  if (crossing.back() && near.empty()) near.enter(b_.scene, hit.instance);
  if (const SurfaceHit* surface = crossing.surface()) {
    find_face(ray, *surface, crossing.offset(), lane);
    return true;
  }
  Interior& far = far_.emplace(lane) = near;
  if (!crossing.cross(b_.scene, &far) && b_.batch.optics) b_.batch.optics->solids_forgotten++;
  if (is_hidden(b_.scene, crossing, near, far, hit.instance)) return false;
  const SurfaceHit& seen = crossing.seen_face(b_.scene, near, far);
  if (seen.instance != hit.instance) find_face(ray, seen, crossing.offset(), lane);
  return true;
}

// Moves the ray from a hidden face to its next hit. False: there is none.
bool PathGlass::next_face(Ray* ray, int lane) {
  Path& path = b_.paths[lane];
  ShadedPoint& point = b_.points[lane];
  if (far_[lane].solid() != near_[lane].solid()) {
    absorb(lane);
    states_[lane].absorbed_to = way_so_far(lane);
  }
  near_[lane] = far_[lane];
  ray->origin = point.spawn_origin(ray->direction);
  path.rays.scatter++;
  if (!b_.intersect(*ray, &path.hit)) return false;
  find_surface(b_.scene, *ray, path.hit, &point);
  path.hit.t = (point.surface.position - path.ray.origin).length();
  return true;
}

void PathGlass::find_indices(int lane) {
  ShadedPoint& point = b_.points[lane];
  PathWavelength& wavelength = states_[lane].wavelength;
  if (!point.surface.material->is_solid()) {
    wavelength.bends = false;
    return;
  }
  b_.samples.resume_sample(lane);
  if (is_flat_solid(b_.scene, b_.paths[lane].hit)) {
    wavelength.bends = false;
    make_wall(near_[lane], point);
  } else {
    set_relative_ior(near_[lane], far_[lane], b_.samples, wavelength, point);
  }
}

// Tinted panes count by luminance, since alpha is a single value.
void PathGlass::show_nothing_behind(LaneList* missed) {
  if (b_.lights.environment() && !b_.settings.transparent) return;
  missed->filter([this](int lane) {
    if (b_.paths[lane].events > 0) return true;
    b_.values[size_t(lane)].alpha = 1.0f - luminance(b_.paths[lane].throughput);
    return false;
  });
}

bool PathGlass::arrives(int lane, CoverageKey key) {
  const bool crosses = may_cross_faces(lane);
  const bool arrives = crosses ? crosses_faces(lane, key) : b_.is_visible(lane, key);
  count_light_sample(lane, key, arrives);
  if (!crosses && arrives) {
    Connection& c = b_.connections[lane];
    c.scattered *= absorption(b_.scene, states_[lane].to_light->solid(), c.light.distance);
  }
  return arrives;
}

// Whether walls or hidden faces may lie between the vertex and the light. crosses_faces() decides
// coverage at random, is_visible() takes its expectation.
bool PathGlass::may_cross_faces(int lane) {
  const Solids* solids = b_.scene.solids();
  const bool inside = !states_[lane].to_light->empty();
  return b_.scene.has_smooth_walls() ||
         (inside && (!b_.scene.has_coverage() || solids->any_are_near())) ||
         (solids && solids->any_let_through());
}

bool PathGlass::crosses_faces(int lane, CoverageKey key) {
  Connection& c = b_.connections[lane];
  Path& path = b_.paths[lane];
  Interior interior = *states_[lane].to_light;
  float travelled;
  c.scattered *=
      through_clear_faces(b_.scene, c.from, c.light, c.target, path.ray.time, key, &interior,
                          &travelled, b_.samples, &path.rays, b_.batch.optics);
  if (is_black(c.scattered)) return false;
  c.scattered *= absorption(b_.scene, interior.solid(), c.light.distance - travelled);
  return true;
}

// Counts light that misses a surface because smooth solid glass bends it; only light samples find
// such light. Which samples are examined depends only on the sample.
void PathGlass::count_light_sample(int lane, CoverageKey key, bool arrives) {
  const Connection& c = b_.connections[lane];
  OpticsCounters* const optics = b_.batch.optics;
  if (!c.light.delta || !b_.scene.has_smooth_solids() || !optics) return;
  if (hash32(std::bit_cast<uint32_t>(c.from.x + c.from.y)) >> 28 != 0) return;
  optics->point_light_samples++;
  const float time = b_.paths[lane].ray.time;
  if (!arrives && blocked_by_glass_alone(b_.scene, c.from, c.light, c.target, time, key)) {
    optics->blocked_by_glass++;
  }
}

}  // namespace emberline
