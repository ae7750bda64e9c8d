// The Embree part of a Scene: the BVHs, and the filter that rejects back faces and uncovered hits.
// Private to this folder.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "renderer/core/load_progress.h"
#include "renderer/scene/embree_api.h"
#include "renderer/scene/embree_isa.h"
#include "renderer/scene/scene.h"

namespace emberline::scene_detail {

// Per-geometry data for the filter callback.
struct GeometryRecord {
  const Mesh* mesh = nullptr;
  // The instance for coverage decisions and visibility. kRayInstance means the instance that Embree
  // reports for the hit.
  uint32_t instance = kRayInstance;
  bool tests_visibility = false;  // whether Mesh::visibility is set
  static constexpr uint32_t kRayInstance = RTC_INVALID_GEOMETRY_ID;
};

// Creates a device, which the caller must release, or returns null on failure (no memory). After
// one failure, further calls do not try again, because Embree 3.13 would create devices whose
// release never returns.
RTCDevice new_device(EmbreeIsa isa);

// An Embree device that reserves its memory from the budget, block by block. `place` appears in its
// error messages. EmbreeScene objects keep the device alive.
class EmbreeDevice {
 public:
  EmbreeDevice(EmbreeIsa isa, std::shared_ptr<MemoryBudget> budget, std::string place);
  ~EmbreeDevice();
  EmbreeDevice(const EmbreeDevice&) = delete;
  EmbreeDevice& operator=(const EmbreeDevice&) = delete;

  RTCDevice handle() const { return device_; }
  // Counts memory that Embree's monitor does not report; see embree_api.h.
  void add_object_bytes(uint64_t bytes);
  void release_object_bytes(uint64_t bytes) noexcept;
  // Returns the number of bytes that Embree holds: BVHs, and objects for meshes, instances and
  // scenes.
  uint64_t bytes() const;
  // Throws InputError if Embree has exceeded the budget since the last call, and RenderError after
  // any other failure.
  void check();

  uint32_t bvh_builds = 0;
  bool has_query_filters = false;  // for Scene::faces_along(); set it before creating scenes

 private:
  static bool count_memory(void* user, ssize_t bytes, bool post);

  RTCDevice device_ = nullptr;
  const std::shared_ptr<MemoryBudget> budget_;
  const std::string place_;
  std::atomic<int64_t> monitored_bytes_{0};  // reported by Embree's memory monitor
  // The size of the first block that exceeded the budget, and what was left of the budget then.
  // Both are stored, because a failing build releases memory before check() reports the error.
  struct Rejection {
    uint64_t bytes = 0, left = 0;
  };
  std::mutex rejection_mutex_;
  Rejection rejection_;
  uint64_t object_bytes_ = 0;
};

// An Embree scene, with its BVH once it is built.
struct EmbreeScene {
  explicit EmbreeScene(std::shared_ptr<EmbreeDevice> device);
  ~EmbreeScene();
  EmbreeScene(const EmbreeScene&) = delete;
  EmbreeScene& operator=(const EmbreeScene&) = delete;

  // Takes over the geometry, which counts as `items` items of LoadProgress.
  void attach(RTCGeometry geometry, uint32_t id, uint64_t items);
  void add_object_bytes(uint64_t bytes);
  void build(LoadProgress& progress);

  const std::shared_ptr<EmbreeDevice> device;
  RTCScene scene = nullptr;

 private:
  uint64_t items_ = 0, object_bytes_ = 0;
};

// The BVHs of a scene. Each mesh must stay at its address, unless its GeometryRecord is updated.
class Geometry {
 public:
  explicit Geometry(std::shared_ptr<EmbreeDevice> device);

  // Builds a BVH over one mesh, which its instances share.
  void build_mesh_scene(Mesh& mesh, LoadProgress& progress);
  // Adds a mesh to the top level; the geometry's id is the instance's index.
  void add_mesh(Mesh& mesh, uint32_t instance) { add_mesh(top_, mesh, instance); }
  void add_instance(const EmbreeScene& mesh_scene, const Affine& transform, uint32_t instance);
  // Adds a moving instance. `steps` are its transforms to internal space at evenly spaced times of
  // the shutter. Returns its index among the moving instances.
  uint32_t add_moving_instance(const EmbreeScene& mesh_scene, std::span<const Mat44d> steps,
                               uint32_t instance);
  struct StaticInstance {
    uint32_t mesh, instance;
    uint64_t key;
    bool operator==(const StaticInstance& o) const {
      return instance == o.instance && key == o.key;
    }
  };
  // Adds meshes that no pose moves. They go into a separate BVH below the top level, where a
  // geometry's id is still the instance's index. Reuses the BVH of `before` if it was built for the
  // same list.
  void add_static_group(std::vector<StaticInstance> list, std::vector<Mesh>& meshes,
                        const Geometry* before, LoadProgress& progress);
  // Returns the transform of a moving instance, in exactly the floats that Embree uses.
  Affine transform_at(uint32_t moving_index, float time) const;
  size_t steps(uint32_t moving_index) const { return moving_instances_[moving_index].steps; }
  // `instances` is the total number of instances.
  void commit(uint32_t instances, LoadProgress& progress);

  RTCScene top() const { return top_.scene; }
  const std::shared_ptr<EmbreeDevice>& device() const { return device_; }

 private:
  struct MovingInstance {
    RTCGeometry geometry;  // in the top level
    size_t steps;
  };
  void add_mesh(EmbreeScene& scene, Mesh& mesh, uint32_t instance);
  RTCGeometry make_triangles(EmbreeScene& scene, Mesh& mesh, uint32_t instance);

  std::shared_ptr<EmbreeDevice> device_;
  EmbreeScene top_;
  std::shared_ptr<const EmbreeScene> static_scene_;
  std::vector<StaticInstance> static_instances_;
  std::vector<MovingInstance> moving_instances_;
};

// Interpolates vertex values at barycentric (u, v) of a triangle.
template <class Values>
[[gnu::always_inline]] inline auto interpolate_vertices(const Values& values,
                                                        const std::array<uint32_t, 3>& index,
                                                        float u, float v) {
  return fma(values[index[2]], v, fma(values[index[1]], u, values[index[0]] * (1.0f - u - v)));
}

// Returns the texture coordinates and the colour at barycentric (u, v) of a triangle.
SurfaceAttributes interpolate_attributes(const Mesh& mesh, uint32_t primitive, float u, float v);

// Returns whether a ray with this key hits the surface. If not, coverage lets the ray pass through.
bool is_covered(const Mesh& mesh, uint32_t instance, uint32_t primitive, float u, float v,
                CoverageKey coverage_key);

inline Vec3d transform_point(const Affine& m, const Vec3d& p) {
  return fma(to_double(m.x), p.x,
             fma(to_double(m.y), p.y, fma(to_double(m.z), p.z, to_double(m.translation))));
}

// Return the bounds of a transformed box, and of vertices without the last entry, which is padding.
Imath::Box3f transformed(const Imath::Box3f& box, const Affine& m);
Imath::Box3f bounds_of(const std::vector<Vec3f>& positions);

// The time segment that contains `time`, given `count` evenly spaced steps over [0, 1]. It is
// computed in float exactly as Embree computes it.
struct TimeSegment {
  size_t step = 0;
  float fraction = 0.0f;  // weight of step + 1

  TimeSegment(float time, size_t count) {
    const float scaled = time * float(count - 1);
    step = std::min(size_t(std::max(scaled, 0.0f)), count - 2);
    fraction = scaled - float(step);
  }
};

// Returns the vertices of a deforming mesh at one of its time steps.
inline const std::vector<Vec3f>& positions_at(const Mesh& mesh, size_t step) {
  return step == 0 ? mesh.positions : mesh.motion[step - 1].positions;
}
std::array<Vec3d, 3> moved_corners(const Mesh& mesh, uint32_t primitive, float time);

// Returns a triangle's corners in object space at a time.
[[gnu::always_inline]] inline std::array<Vec3d, 3> corners_at(const Mesh& mesh, uint32_t primitive,
                                                              float time) {
  if (!mesh.motion.empty()) [[unlikely]]
    return moved_corners(mesh, primitive, time);
  const std::array<uint32_t, 3>& index = mesh.triangles[primitive];
  return {to_double(mesh.positions[index[0]]), to_double(mesh.positions[index[1]]),
          to_double(mesh.positions[index[2]])};
}

// Returns a placed triangle's corners in internal space; `instance` must have its transform at
// `time`.
inline std::array<Vec3d, 3> placed_corners(const Mesh& mesh, const Instance& instance,
                                           uint32_t primitive, float time = 0.0f) {
  std::array<Vec3d, 3> p = corners_at(mesh, primitive, time);
  if (!instance.transformed) return p;
  for (Vec3d& corner : p) corner = transform_point(instance.to_internal, corner);
  return p;
}

// Returns whether the placed mesh's position depends on the ray's time.
inline bool moves(const Mesh& mesh, const Instance& instance) {
  return instance.moving_index != Instance::kStatic || !mesh.motion.empty();
}

// Returns an upper bound, in internal space, on the distance between a triangle's plane and the
// points that Embree or Scene::interaction() computes for hits on the triangle. `instance` must
// have its transform at `time`. The second form is for triangles whose coordinates are at most
// `largest` in magnitude.
float plane_error(const Mesh& mesh, const Instance& instance, uint32_t primitive,
                  float time = 0.0f);
float plane_error(float largest, const Instance& instance);

// Builds the BVH of a scene, which counts as `items` items of `progress`. Throws Cancelled.
void build_bvh(RTCScene scene, LoadProgress& progress, uint64_t items);

RTCRay make_ray(const Vec3f& origin, const Vec3f& direction, float t_max, float time = 0.0f);
// Returns a ray that has hit nothing yet.
RTCRayHit make_ray_hit(const RTCRay& ray);

}  // namespace emberline::scene_detail
