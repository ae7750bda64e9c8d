// Glass in the path loop: the solids that a path is inside of, thin walls and dispersion.
//
// PathLoop has one of the two classes below as a policy and calls its hooks; `lane` numbers a path
// of the batch.
#pragma once

#include <utility>

#include "integrators/path_batch.h"
#include "integrators/path_media.h"
#include "renderer/scene/interior.h"

namespace emberline {

// For scenes whose materials transmit no light.
class NoGlass {
 public:
  static constexpr bool kPresent = false;
  explicit NoGlass(PathBatch& batch) : b_(batch) {}
  static void begin(int) {}
  static void skip_hidden_faces(LaneList*) {}
  static void find_indices(int) {}
  static void absorb(int) {}
  static bool transmits(const SurfaceBsdf&) { return false; }
  static bool is_clear_wall(int) { return false; }
  const LastVertex& scattered_at(int lane) { return b_.paths[lane].last; }
  float distance_from(int lane) { return b_.paths[lane].hit.t; }
  static void show_nothing_behind(LaneList*) {}
  static void connect(int, const Vec3f&) {}
  bool arrives(int lane, CoverageKey key) { return b_.is_visible(lane, key); }
  static void scatter(int, const BsdfSample&) {}
  static bool goes_straight(int, const BsdfSample&) { return false; }
  static bool pass_wall(int) { return false; }
  static void leave(int) {}

 private:
  PathBatch& b_;
};

class PathGlass {
 public:
  static constexpr bool kPresent = true;
  explicit PathGlass(PathBatch& batch) : b_(batch) {}

  void begin(int lane) {
    states_.emplace(lane);
    near_.emplace(lane);
    if (b_.batch.interiors) near_[lane] = b_.batch.interiors[size_t(lane)];
  }

  // Moves the hits on hidden faces of solids on to surfaces that the paths see. Paths that leave
  // the scene go from b_.alive to `missed`.
  void skip_hidden_faces(LaneList* missed);

  // Gives the surface its index of refraction, or makes a face of a flat solid a thin wall.
  void find_indices(int lane);

  // Multiplies the throughput by the absorption on the way to the surface.
  void absorb(int lane) {
    if (!near_[lane].solid()) return;
    const float distance = way_so_far(lane) - states_[lane].absorbed_to;
    b_.paths[lane].throughput *= absorption(b_.scene, near_[lane].solid(), distance);
  }

  static bool transmits(const SurfaceBsdf& bsdf) { return bsdf.transmits_non_delta(); }
  // Whether a path that may not scatter goes on here.
  bool is_clear_wall(int lane) { return is_smooth_wall(b_.scene, b_.paths[lane].hit); }

  // The vertex whose light sample may find what the ray finds: where it was scattered. Since then
  // it may have come straight through smooth thin walls, which a light sample sees through, too.
  const LastVertex& scattered_at(int lane) { return states_[lane].vertex; }
  // From that vertex to the hit.
  float distance_from(int lane) {
    if (states_[lane].walls == 0) return b_.paths[lane].hit.t;
    return (b_.points[lane].surface.position - states_[lane].vertex.query.point).length();
  }

  // Where nothing is behind the panes that the camera sees, the sample's alpha is what they hold
  // back. Takes those paths off the list if the camera does not see the environment.
  void show_nothing_behind(LaneList* missed);

  // Connections: a light sample leaves the vertex along wi, in local space.
  void connect(int lane, const Vec3f& wi) {
    State& state = states_[lane];
    const bool passes = wi.z < 0.0f && b_.points[lane].surface.material->is_solid();
    state.to_light = passes ? &far_[lane] : &near_[lane];
    const PathWavelength& wavelength = state.wavelength;
    if (wavelength.bends && wi.z < 0.0f) b_.connections[lane].scattered *= wavelength.weight;
  }
  // Whether the connection's light reaches the vertex; multiplies it by what the way lets through.
  bool arrives(int lane, CoverageKey key);

  // The BSDF sample has been taken.
  void scatter(int lane, const BsdfSample& next) {
    Path& path = b_.paths[lane];
    path.eta_scale *= next.eta_scale;
    if (!next.transmitted) return;
    if (b_.points[lane].surface.material->is_solid()) near_[lane] = far_[lane];
    PathWavelength& wavelength = states_[lane].wavelength;
    if (wavelength.bends) path.throughput *= std::exchange(wavelength.weight, Rgb(1.0f));
  }
  bool goes_straight(int lane, const BsdfSample& next) {
    return next.delta && next.transmitted && b_.points[lane].material.bsdf.thin_walled;
  }
  // The path goes straight on. False: through too many walls.
  bool pass_wall(int lane) {
    states_[lane].absorbed_to = 0.0f;
    if (++states_[lane].walls <= kMostWalls) return true;
    if (b_.batch.optics) b_.batch.optics->rays_ended_at_walls++;
    return false;
  }
  // The path is scattered.
  void leave(int lane) {
    State& state = states_[lane];
    state.absorbed_to = 0.0f;
    state.vertex = b_.paths[lane].last;
    state.walls = 0;
  }

 private:
  struct State {
    LastVertex vertex;   // where the path was scattered
    uint32_t walls = 0;  // passed since
    PathWavelength wavelength;
    // Distance along the ray at which the solid around it changed last, at a hidden face.
    float absorbed_to = 0.0f;
    const Interior* to_light = nullptr;  // where the way to the sampled light begins
  };

  // From point to point: hit.t starts at the offset origin, which matters in a thin slab.
  float way_so_far(int lane) {
    if (b_.depth == 0) return b_.paths[lane].hit.t;
    return (b_.points[lane].surface.position - b_.paths[lane].last.query.point).length();
  }
  void find_face(const Ray& ray, const SurfaceHit& face, float offset, int lane);
  bool find_seen_face(int lane);
  bool is_seen(const SolidCrossing& crossing, const Ray& ray, int lane);
  bool next_face(Ray* ray, int lane);

  bool may_cross_faces(int lane);
  bool crosses_faces(int lane, CoverageKey key);
  void count_light_sample(int lane, CoverageKey key, bool arrives);

  PathBatch& b_;
  LaneArray<State> states_;
  LaneArray<Interior> near_;  // where the ray is
  LaneArray<Interior> far_;   // behind the surface that it hit, if that is a face of a solid
};

}  // namespace emberline
