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
#include <span>
#include <unordered_map>
#include <vector>

#include "renderer/scene/flush_search.h"

namespace emberline::scene_detail {

class FlushEmitters {
 public:
  // Null if there are none. The arguments must outlive the result; `geometry` is committed. As
  // find_flush_surfaces says. Throws Cancelled.
  static std::unique_ptr<FlushEmitters> find(const std::vector<Mesh>& meshes,
                                             const std::vector<Instance>& instances,
                                             const ShownInstances& shown, const Geometry& geometry,
                                             const std::vector<EmissiveTriangle>& emitters,
                                             LoadProgress& progress);
  ~FlushEmitters();
  FlushEmitters(const FlushEmitters&) = delete;
  FlushEmitters& operator=(const FlushEmitters&) = delete;

  size_t size() const { return members_.size(); }
  bool contains(uint32_t emitter) const { return reach_[emitter] > 0.0f; }
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
  FlushEmitters(const std::vector<Mesh>& meshes, const std::vector<Instance>& instances,
                const ShownInstances& shown, const std::vector<EmissiveTriangle>& emitters,
                FlushSurfaces found);
  void build(const Geometry& geometry);
  static void keep_lowest(const RTCFilterFunctionNArguments* arguments);

  const std::vector<Mesh>& meshes_;
  const std::vector<Instance>& instances_;
  const ShownInstances& shown_;
  const std::vector<EmissiveTriangle>& emitters_;
  std::vector<float> reach_;  // as in FlushSurfaces, and offsets_
  float longest_reach_ = 0.0f;
  std::unordered_map<uint64_t, float> offsets_;
  std::vector<uint32_t> members_;  // the emitter of each triangle of scene_
  RTCScene scene_ = nullptr;       // the members alone
};

}  // namespace emberline::scene_detail
