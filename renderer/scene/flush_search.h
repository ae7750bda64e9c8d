// Which emitters lie in which surfaces, and how far from one another rounding can place the two.
// Private to this folder; what is made of it is in flush_emitters.h.
//
// Each triangle has an error of its own (plane_error), that grows with its coordinates: one far
// away may be off by more than a hundred near ones are large. So an emitter asks the BVH about what
// is as exact as itself, and surfaces that are much less so look for the emitters that they reach,
// in a tree of their points. A single radius for all would make every emitter meet every other.
#pragma once

#include <unordered_map>
#include <vector>

#include "renderer/scene/geometry.h"

namespace emberline::scene_detail {

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
// in one another at one place. `geometry` is committed. O(n log n). Throws Cancelled.
FlushSurfaces find_flush_surfaces(const std::vector<Mesh>& meshes,
                                  const std::vector<Instance>& instances,
                                  const std::vector<EmissiveTriangle>& emitters,
                                  LoadProgress& progress);

}  // namespace emberline::scene_detail
