// Emitters that lie in another surface, such as a lamp's quad flush with its ceiling, or a lamp
// that the file contains twice. Rounding would decide for each ray which surface is in front: the
// lamp would show spots of the ceiling and lose light, and two coincident lamps would emit twice as
// much as one. Instead, such an emitter is always in front of the surface that it lies in, on every
// side on which it emits; among emitters, the one with the lowest index is in front.
//
// A scene without such emitters has no object of this class and pays only one untaken branch per
// hit. Immutable and thread-safe once built. Private to this folder.
#pragma once

#include <memory>
#include <unordered_map>
#include <utility>
#include <vector>

#include "renderer/scene/geometry.h"

namespace emberline::scene_detail {

// The scene data of emitters; it must outlive all objects built from it.
struct PlacedEmitters {
  const std::vector<Mesh>& meshes;
  const std::vector<Instance>& instances;
  const InstanceVisibility& visibility;
  const std::vector<EmissiveTriangle>& emitters;
};

// The emitters that lie in surfaces, and these surfaces.
struct FlushSurfaces {
  // For each emitter, a bound on the distance that Embree's rounding puts between it and the
  // surface that it lies in; 0 if it lies in no surface.
  std::vector<float> reach;
  // For each triangle that is a flush emitter or contains one, the largest of these bounds. The key
  // is surface_key().
  std::unordered_map<uint64_t, float> offsets;
};

inline uint64_t surface_key(uint32_t instance, uint32_t primitive) {
  return uint64_t(instance) << 32 | primitive;
}

// Searches static geometry. It tests four points of each emitting triangle (one if there are many
// emitters), so it misses overlaps that contain none of these points. It also misses some surfaces
// if more than about a hundred coincide. Takes O(n log n) time. Throws Cancelled.
FlushSurfaces find_flush_surfaces(const PlacedEmitters& placed, LoadProgress& progress);

class FlushEmitters {
 public:
  // Returns null if no emitter lies in a surface. `geometry` must be committed. See
  // find_flush_surfaces(). Throws Cancelled.
  static std::unique_ptr<FlushEmitters> find(const PlacedEmitters& placed, const Geometry& geometry,
                                             LoadProgress& progress);
  ~FlushEmitters();
  FlushEmitters(const FlushEmitters&) = delete;
  FlushEmitters& operator=(const FlushEmitters&) = delete;

  size_t size() const { return flush_emitters_.size(); }
  bool contains(uint32_t emitter) const { return surfaces_.reach[emitter] > 0.0f; }
  // Returns the ray offset of a triangle that is flush or contains a flush emitter, and 0 for any
  // other triangle.
  float offset(uint32_t instance, uint32_t primitive) const;

  struct Candidate {
    uint32_t emitter;  // only lower indices are searched
    float t, u, v;     // u, v for the order of the mesh's vertices
  };
  // Searches the emitters with an index below candidate->emitter for those that lie in the surface
  // that the ray hits at `t`. If there are any, replaces *candidate with the one with the lowest
  // index and returns true. `cosine` is the absolute dot product of the surface's normal and the
  // unnormalised direction.
  bool find_lowest_emitter(const Ray& ray, float t, float cosine, CoverageKey coverage_key,
                           Candidate* candidate) const;

 private:
  FlushEmitters(const PlacedEmitters& placed, FlushSurfaces surfaces)
      : placed_(placed), surfaces_(std::move(surfaces)) {}
  void build(const Geometry& geometry);
  static void keep_lowest(const RTCFilterFunctionNArguments* arguments);

  const PlacedEmitters placed_;
  const FlushSurfaces surfaces_;
  float max_reach_ = 0.0f;
  std::vector<uint32_t> flush_emitters_;  // emitter of each triangle in scene_
  RTCScene scene_ = nullptr;              // contains only the flush emitters
};

}  // namespace emberline::scene_detail
