// Glass in the path loop: the solids that a path is inside of, thin walls and dispersion. A face of
// a solid is hidden if paths go straight through it without reflection or refraction (is_hidden()
// in path_media.h).
//
// PathLoop takes one of the two classes below as a policy and calls its hooks; `lane` is a path's
// index in the batch.
#pragma once

#include <utility>

#include "integrators/path_batch.h"
#include "integrators/path_media.h"
#include "renderer/scene/interior.h"

namespace emberline {

// For scenes whose materials transmit no light.
class NoGlass {
 public:
  static constexpr bool kEnabled = false;
  explicit NoGlass(PathBatch& batch) : b_(batch) {}
  static void begin(int) {}
  static void skip_hidden_faces(LaneList*) {}
  static void update_ior(int) {}
  static void absorb(int) {}
  static bool transmits(const SurfaceBsdf&) { return false; }
  static bool is_clear_wall(int) { return false; }
  const LastVertex& scattering_vertex(int lane) { return b_.paths[lane].last; }
  float distance_from_vertex(int lane) { return b_.paths[lane].hit.t; }
  static void hide_background(LaneList*) {}
  static void connect(int, const Vec3f&) {}
  bool arrives(int lane, CoverageKey key) { return b_.is_visible(lane, key); }
  static void scatter(int, const BsdfSample&) {}
  static bool is_straight_passage(int, const BsdfSample&) { return false; }
  static bool count_wall(int) { return false; }
  static void leave(int) {}

 private:
  PathBatch& b_;
};

class PathGlass {
 public:
  static constexpr bool kEnabled = true;
  explicit PathGlass(PathBatch& batch) : b_(batch) {}

  void begin(int lane) {
    states_.emplace(lane);
    near_.emplace(lane);
    if (b_.batch.interiors) near_[lane] = b_.batch.interiors[size_t(lane)];
  }

  // Replaces each hit on a hidden face of a solid by a hit on the first visible surface behind that
  // face. Paths that leave the scene move from b_.alive to `missed`.
  void skip_hidden_faces(LaneList* missed);

  // Sets the surface's index of refraction, or turns a face of a flat solid into a thin wall.
  void update_ior(int lane);

  void absorb(int lane) {
    if (!near_[lane].medium()) return;
    const float distance = distance_from_last_vertex(lane) - states_[lane].absorbed_distance;
    b_.paths[lane].throughput *= absorption(b_.scene, near_[lane].medium(), distance);
  }

  static bool transmits(const SurfaceBsdf& bsdf) { return bsdf.transmits_non_delta(); }
  // Returns whether a path that may not scatter any more continues straight through the surface.
  bool is_clear_wall(int lane) { return is_smooth_wall(b_.scene, b_.paths[lane].hit); }

  // Returns the last vertex that scattered the path. Its light samples may find the same light as
  // the current ray, even if the path has passed smooth thin walls since then, because light
  // samples also see through such walls.
  const LastVertex& scattering_vertex(int lane) { return states_[lane].vertex; }
  // Returns the distance from scattering_vertex() to the hit.
  float distance_from_vertex(int lane) {
    if (states_[lane].walls == 0) return b_.paths[lane].hit.t;
    return (b_.points[lane].surface.position - states_[lane].vertex.query.point).length();
  }

  // If the camera does not see the environment, handles the camera paths that leave the scene
  // straight through thin walls. Sets the alpha of these paths to the fraction of light that the
  // walls block, and removes the paths from `missed`.
  void hide_background(LaneList* missed);

  // Called when a light sample leaves the vertex in direction `wi`, which is in local space.
  void connect(int lane, const Vec3f& wi) {
    State& state = states_[lane];
    const bool passes = wi.z < 0.0f && b_.points[lane].surface.material->is_solid();
    state.connection_interior = passes ? &far_[lane] : &near_[lane];
    const PathWavelength& wavelength = state.wavelength;
    if (wavelength.is_dispersive && wi.z < 0.0f)
      b_.connections[lane].scattered *= wavelength.weight;
  }
  // Returns whether the connection's light reaches the vertex. Multiplies the light by the
  // transmittance.
  bool arrives(int lane, CoverageKey key);

  // Updates the medium, wavelength and radiance compression of the path after a BSDF sample.
  void scatter(int lane, const BsdfSample& next) {
    Path& path = b_.paths[lane];
    path.eta_scale *= next.eta_scale;
    if (!next.transmitted) return;
    if (b_.points[lane].surface.material->is_solid()) near_[lane] = far_[lane];
    PathWavelength& wavelength = states_[lane].wavelength;
    if (wavelength.is_dispersive) path.throughput *= std::exchange(wavelength.weight, Rgb(1.0f));
  }
  bool is_straight_passage(int lane, const BsdfSample& next) {
    return next.delta && next.transmitted && b_.points[lane].material.bsdf.thin_walled;
  }
  // Called when the path goes straight through a wall. Returns false if the path has passed too
  // many walls.
  bool count_wall(int lane) {
    states_[lane].absorbed_distance = 0.0f;
    if (++states_[lane].walls <= kMaxWalls) return true;
    if (b_.batch.optics) b_.batch.optics->rays_ended_at_panes++;
    return false;
  }
  // Called when the path leaves a vertex that scattered it.
  void leave(int lane) {
    State& state = states_[lane];
    state.absorbed_distance = 0.0f;
    state.vertex = b_.paths[lane].last;
    state.walls = 0;
  }

 private:
  struct State {
    LastVertex vertex;   // where the path was last scattered
    uint32_t walls = 0;  // walls passed since then
    PathWavelength wavelength;
    // Distance along the ray to the last hidden face at which the medium changed. Absorption has
    // been applied up to this face.
    float absorbed_distance = 0.0f;
    const Interior* connection_interior = nullptr;  // the solids at the start of the connection
  };

  // Returns the distance between the surface points of the last vertex and of the hit. In contrast,
  // hit.t is measured from the ray's offset origin; the difference matters in thin slabs.
  float distance_from_last_vertex(int lane) {
    if (b_.depth == 0) return b_.paths[lane].hit.t;
    return (b_.points[lane].surface.position - b_.paths[lane].last.query.point).length();
  }
  void replace_hit(const Ray& ray, const SurfaceHit& face, float offset, int lane);
  bool find_visible_face(int lane);
  bool resolve_crossing(const SolidCrossing& crossing, const Ray& ray, int lane);
  bool next_face(Ray* ray, int lane);

  bool may_cross_clear_faces(int lane);
  bool trace_clear_faces(int lane, CoverageKey key);
  void count_light_sample(int lane, CoverageKey key, bool arrives);

  PathBatch& b_;
  LaneArray<State> states_;
  LaneArray<Interior> near_;  // the solids around the ray
  LaneArray<Interior> far_;   // the solids behind the hit surface, if it is a face of a solid
};

}  // namespace emberline
