// Emitters that lie in another surface: a lamp's quad flush with its ceiling, a lamp that the file
// holds twice. Rounding alone would decide, ray by ray, which of the two is in front: the lamp
// shows the ceiling in spots, loses light to it, and two lamps in one another shine like two. One
// rule decides for every ray: such an emitter is in front of what it lies in, on every side that
// it shines to, and the one of lowest index is in front of the others.
//
// A scene without any has none of this: no object, one untaken branch per hit. Immutable and
// thread-safe once built. Private to this folder.
#pragma once

#include <memory>
#include <unordered_map>
#include <utility>
#include <vector>

#include "renderer/scene/geometry.h"

namespace emberline::scene_detail {

// What a scene has of its emitters, which must outlive whatever is made of them here.
struct PlacedEmitters {
  const std::vector<Mesh>& meshes;
  const std::vector<Instance>& instances;
  const ShownInstances& shown;
  const std::vector<EmissiveTriangle>& emitters;
};

// Which emitters lie in which surfaces, and how far from one another rounding can place the two.
struct FlushSurfaces {
  // Per emitter: bound of the distance at which Embree may see it and what it lies in; 0: it lies
  // in nothing.
  std::vector<float> reach;
  // By surface_key: the same of every triangle that is one, or that one lies in.
  std::unordered_map<uint64_t, float> offsets;
};

inline uint64_t surface_key(uint32_t instance, uint32_t primitive) {
  return uint64_t(instance) << 32 | primitive;
}

// Of what is at rest. Asks at four points of each emitting triangle (at one, if they are many): an
// overlap that spares them is not seen, nor are all of those beyond some hundred surfaces that lie
// in one another at one place. O(n log n). Throws Cancelled.
FlushSurfaces find_flush_surfaces(const PlacedEmitters& placed, LoadProgress& progress);

class FlushEmitters {
 public:
  // Null if there are none. `geometry` is committed. As find_flush_surfaces says. Throws Cancelled.
  static std::unique_ptr<FlushEmitters> find(const PlacedEmitters& placed, const Geometry& geometry,
                                             LoadProgress& progress);
  ~FlushEmitters();
  FlushEmitters(const FlushEmitters&) = delete;
  FlushEmitters& operator=(const FlushEmitters&) = delete;

  size_t size() const { return members_.size(); }
  bool contains(uint32_t emitter) const { return surfaces_.reach[emitter] > 0.0f; }
  // How far rays must start and end from a triangle that is one, or that one lies in; else 0.
  float offset(uint32_t instance, uint32_t primitive) const;

  struct Candidate {
    uint32_t emitter;  // of this index and above there is nothing to look for
    float t, u, v;     // u, v as the mesh counts them
  };
  // Whether an emitter of an index below candidate->emitter lies in the surface that the ray meets
  // at `t` under `cosine` (of the unnormalised direction); the lowest one replaces *candidate.
  bool lowest_at(const Ray& ray, float t, float cosine, CoverageKey coverage_key,
                 Candidate* candidate) const;

 private:
  FlushEmitters(const PlacedEmitters& placed, FlushSurfaces surfaces)
      : placed_(placed), surfaces_(std::move(surfaces)) {}
  void build(const Geometry& geometry);
  static void keep_lowest(const RTCFilterFunctionNArguments* arguments);

  const PlacedEmitters placed_;
  const FlushSurfaces surfaces_;
  float longest_reach_ = 0.0f;
  std::vector<uint32_t> members_;  // the emitter of each triangle of scene_
  RTCScene scene_ = nullptr;       // the members alone
};

}  // namespace emberline::scene_detail
