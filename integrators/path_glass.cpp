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
    if (!(is_solid || any_touch) || find_visible_face(lane)) return true;
    missed->add(lane);
    return false;
  });
}

// Replaces the lane's hit by a hit on `face`.
void PathGlass::replace_hit(const Ray& ray, const SurfaceHit& face, float offset, int lane) {
  SurfaceHit& hit = b_.paths[lane].hit;
  hit = {hit.t, face.u, face.v, face.instance, face.primitive};
  find_surface(b_.scene, ray, hit, &b_.points[lane]);
  b_.points[lane].surface.offset = offset;
}

// Follows the ray through hidden faces of solids to a visible surface. Returns false if the ray
// leaves the scene or passes too many hidden faces.
bool PathGlass::find_visible_face(int lane) {
  Path& path = b_.paths[lane];
  ShadedPoint& point = b_.points[lane];
  Ray ray = path.ray;
  for (uint32_t faces = 0; point.surface.material->is_solid(); ++faces) {
    if (faces == 0 && b_.scene.has_coverage()) b_.samples.resume_sample(lane);
    const SolidCrossing crossing(b_.scene, point.surface, path.hit, ray,
                                 coverage_key(b_.scene, b_.samples));
    if (resolve_crossing(crossing, ray, lane)) return true;
    if (faces == kMaxWalls) {
      if (b_.batch.optics) b_.batch.optics->rays_ended_at_panes++;
      path.throughput = Rgb(0.0f);
      return false;
    }
    if (!next_face(&ray, lane)) return false;
  }
  // If a solid's face coincides with this surface, the next ray must start beyond the face as well.
  if (b_.scene.solids()->may_coincide(path.hit.instance, path.hit.primitive)) {
    point.surface.offset *= SolidCrossing::kReach;
  }
  return true;
}

// Returns whether the path sees the faces that it crosses, or sees a surface that lies in these
// faces. If so, replaces the hit by a hit on the face or surface that scatters.
bool PathGlass::resolve_crossing(const SolidCrossing& crossing, const Ray& ray, int lane) {
  const SurfaceHit& hit = b_.paths[lane].hit;
  Interior& near = near_[lane];
  b_.points[lane].surface.offset = crossing.offset();
  // If a path outside all solids meets a back face, the camera is inside an open solid.
  if (crossing.is_exit() && near.empty()) near.enter(b_.scene, hit.instance);
  if (const SurfaceHit* surface = crossing.surface()) {
    replace_hit(ray, *surface, crossing.offset(), lane);
    return true;
  }
  Interior& far = far_.emplace(lane) = near;
  if (!crossing.cross(b_.scene, &far) && b_.batch.optics) b_.batch.optics->dropped_solids++;
  if (is_hidden(b_.scene, crossing, near, far, hit.instance)) return false;
  const SurfaceHit& seen = crossing.visible_face(b_.scene, near, far);
  if (seen.instance != hit.instance) replace_hit(ray, seen, crossing.offset(), lane);
  return true;
}

// Continues the ray beyond a hidden face to its next hit. Returns false if the ray hits nothing
// more.
bool PathGlass::next_face(Ray* ray, int lane) {
  Path& path = b_.paths[lane];
  ShadedPoint& point = b_.points[lane];
  if (far_[lane].medium() != near_[lane].medium()) {
    absorb(lane);
    states_[lane].absorbed_distance = distance_from_last_vertex(lane);
  }
  near_[lane] = far_[lane];
  ray->origin = point.spawn_origin(ray->direction);
  path.rays.scatter++;
  if (!b_.intersect(*ray, &path.hit)) return false;
  find_surface(b_.scene, *ray, path.hit, &point);
  path.hit.t = (point.surface.position - path.ray.origin).length();
  return true;
}

void PathGlass::update_ior(int lane) {
  ShadedPoint& point = b_.points[lane];
  PathWavelength& wavelength = states_[lane].wavelength;
  if (!point.surface.material->is_solid()) {
    wavelength.is_dispersive = false;
    return;
  }
  b_.samples.resume_sample(lane);
  if (is_flat_solid(b_.scene, b_.paths[lane].hit)) {
    wavelength.is_dispersive = false;
    make_thin_walled(near_[lane], point);
  } else {
    set_relative_ior(near_[lane], far_[lane], b_.samples, wavelength, point);
  }
}

// Alpha is a single value, so the transmittance of tinted walls is reduced to its luminance.
void PathGlass::hide_background(LaneList* missed) {
  if (b_.lights.environment() && !b_.settings.transparent) return;
  missed->filter([this](int lane) {
    if (b_.paths[lane].events > 0) return true;
    b_.values[size_t(lane)].alpha = 1.0f - luminance(b_.paths[lane].throughput);
    return false;
  });
}

bool PathGlass::arrives(int lane, CoverageKey key) {
  const bool crosses = may_cross_clear_faces(lane);
  const bool arrives = crosses ? trace_clear_faces(lane, key) : b_.is_visible(lane, key);
  count_light_sample(lane, key, arrives);
  if (!crosses && arrives) {
    Connection& c = b_.connections[lane];
    c.scattered *=
        absorption(b_.scene, states_[lane].connection_interior->medium(), c.light.distance);
  }
  return arrives;
}

// Returns whether walls or hidden faces may lie between the vertex and the light. If not,
// is_visible() is less noisy than trace_clear_faces(): it multiplies the light by the coverage,
// while trace_clear_faces() decides at random whether a partly covered surface is hit.
bool PathGlass::may_cross_clear_faces(int lane) {
  const Solids* solids = b_.scene.solids();
  const bool inside = !states_[lane].connection_interior->empty();
  return b_.scene.has_smooth_walls() ||
         (inside && (!b_.scene.has_coverage() || solids->has_near_solids())) ||
         (solids && solids->has_straight_transmission());
}

bool PathGlass::trace_clear_faces(int lane, CoverageKey key) {
  Connection& c = b_.connections[lane];
  Path& path = b_.paths[lane];
  Interior interior = *states_[lane].connection_interior;
  float medium_start;
  c.scattered *=
      clear_transmittance(b_.scene, c.from, c.light, c.target, path.ray.time, key, &interior,
                          &medium_start, b_.samples, &path.rays, b_.batch.optics);
  if (is_black(c.scattered)) return false;
  c.scattered *= absorption(b_.scene, interior.medium(), c.light.distance - medium_start);
  return true;
}

// Counts samples of point-like lights that do not reach the surface because smooth solid glass
// would bend their light. No other kind of sample can find these lights. One sample in 16 is
// examined, chosen by a hash of its origin.
void PathGlass::count_light_sample(int lane, CoverageKey key, bool arrives) {
  const Connection& c = b_.connections[lane];
  OpticsCounters* const optics = b_.batch.optics;
  if (!c.light.delta || !b_.scene.has_smooth_solids() || !optics) return;
  if (hash32(std::bit_cast<uint32_t>(c.from.x + c.from.y)) >> 28 != 0) return;
  optics->point_light_samples++;
  const float time = b_.paths[lane].ray.time;
  if (!arrives && is_blocked_only_by_glass(b_.scene, c.from, c.light, c.target, time, key)) {
    optics->blocked_by_glass++;
  }
}

}  // namespace emberline
