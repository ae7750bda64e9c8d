// The parts of a scene that a frame needs, ready for tracing: geometry in an Embree BVH, compiled
// materials and the light sampler. build_scene() builds the object. Afterwards it is immutable and
// thread-safe, except for update_scene() on editable scenes.
//
// Internal space: internal = (world - origin()) * scale(). A scene far from the world's origin is
// translated in double precision before it is rounded to float; a scene of extreme size is scaled
// by a power of two, which is exact. Divide by scale() to show lengths to users.
#pragma once

#include <Imath/ImathBox.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "renderer/core/ray.h"
#include "renderer/core/vector.h"
#include "renderer/description/mesh_arrays.h"
#include "renderer/lights/light_sampler.h"
#include "renderer/shading/material.h"
#include "samplers/coverage_key.h"

namespace emberline {

// Closest intersection as found by Embree.
struct SurfaceHit {
  float t = 0.0f;
  float u = 0.0f, v = 0.0f;  // barycentric weights of the triangle's second and third vertex
  uint32_t instance = 0;     // index of the placed mesh
  uint32_t primitive = 0;    // triangle in the mesh
};

// The hit point with all data for shading.
struct SurfaceInteraction {
  Vec3f position;
  // Upper bound on the position's distance from the plane that Embree tests. Outgoing rays start at
  // position +- offset * geometric_normal, see offset_ray_origin().
  float offset = 0.0f;
  Vec3f geometric_normal;  // unit length, on the triangle's front side
  Vec3f shading_normal;    // unit length, front side; geometric_normal if there is none
  // The tangent (xyz, in internal space) and its handedness (w); all 0 if the mesh has no tangents.
  // Tangent and colour are set only if the material reads them (Material::reads_attributes).
  Vec4f tangent;
  SurfaceAttributes attributes{SurfaceAttributes::Unread{}};
  uint32_t instance = 0;
  const Material* material = nullptr;
  uint32_t material_index = 0;  // index in the description; one past the last means the default
                                // material
};

// Moves a ray's origin off the surface, to the side of `direction`. The distance is an error bound,
// not a tuned epsilon: 4 ulp of the largest coordinate in the computation.
[[gnu::always_inline]] inline Vec3f offset_ray_origin(const Vec3f& position,
                                                      const Vec3f& geometric_normal, float offset,
                                                      const Vec3f& direction) {
  return fma(geometric_normal, dot(direction, geometric_normal) < 0.0f ? -offset : offset,
             position);
}

// A face crossed by a short ray.
struct CrossedFace {
  SurfaceHit hit;        // t is along that ray
  bool is_exit = false;  // the ray hits it from behind, leaving a solid
};

// Memory use of a built scene. Only the images of materials that placed meshes use are kept and
// counted.
struct SceneMemory {
  uint64_t geometry_bytes = 0;      // vertices, indices, attributes, instances, emitters, light BVH
  uint64_t bvh_bytes = 0;           // what Embree's monitor reports, plus the sizes in embree_api.h
  uint64_t texture_bytes = 0;       // resident texels, each image once, and the environment and its
                                    // tables
  uint64_t texture_file_bytes = 0;  // texels kept in a file instead (LoadLimits)
};

class Solids;

namespace scene_detail {

// For each instance, the times at which it is visible; null means always. The vector is empty if
// all instances are always visible.
using InstanceVisibility = std::vector<std::shared_ptr<const VisibilityTimes>>;

// A mesh as the boundary of a solid, in object space; see solids.h.
struct SolidShape {
  bool closed = false;
  double volume = 0.0;  // enclosed volume; undefined for an open mesh
  Imath::Box3f bounds;  // over the whole shutter
};

struct GeometryRecord;  // mesh data for the BVH's filter
struct EmbreeScene;     // an Embree scene

// A mesh's arrays and their Embree data, which a new pose takes over unchanged. They are in object
// space if the mesh is instanced, otherwise in internal space. `positions` has a spare entry at the
// end, because Embree reads 16 bytes per vertex. `next_frame`, for NextFramePlacement, is in object
// space; if it is empty, `positions` is used instead.
struct ReusableMesh : MeshArrays {
  std::optional<SolidShape> solid;  // computed on demand
  bool is_baked = false;
  std::shared_ptr<GeometryRecord> record;  // null without a filter
  std::shared_ptr<const EmbreeScene> bvh;  // set only for instanced meshes
};

struct Mesh : ReusableMesh {
  const Material* material = nullptr;
  uint32_t material_index = 0;
  bool cull_backfaces = false;
  bool culling_may_change = false;  // an update may change cull_backfaces
  bool coverage_may_change = false;
  // True if the material reads the result of interpolate_attributes().
  bool has_attributes = false;
  bool has_coverage = false;
  const InstanceVisibility* visibility = nullptr;  // set if an instance is not always visible
};

// Row-vector affine transform in the same floats that Embree gets.
struct Affine {
  Vec3f x, y, z, translation;
  bool operator==(const Affine&) const = default;
};

struct Instance {
  uint32_t mesh = 0;
  bool transformed = false;  // false: the mesh is already in internal space
  bool mirrored = false;
  uint32_t first_emitter = 0xffffffffu;  // index of triangle 0's emitter, if the mesh emits
  // Index among Geometry's moving instances, or kStatic. If the instance moves, to_internal is its
  // transform at shutter open.
  uint32_t moving_index = kStatic;
  static constexpr uint32_t kStatic = 0xffffffffu;
  Affine to_internal;
  Affine normal_transform;  // rows of the inverse transpose; translation is unused
};

// The placement of a moving instance one frame after the rendered instant (NextFrameInstance).
struct NextFramePlacement {
  uint32_t instance = 0;
  // Transform to internal space. It applies to the mesh's `next_frame` or, if that is empty, to its
  // `positions`.
  Mat44d to_internal;
};
class Geometry;       // Embree handles
class FlushEmitters;  // flush_emitters.h

}  // namespace scene_detail

class Scene : private EmitterMotion {
 public:
  ~Scene() override;
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  // Finds the closest surface along the ray; returns false if there is none. The ray skips back
  // faces of single-sided materials and holes of alpha coverage. Whether it hits a partly covered
  // surface depends only on (coverage_key, instance, primitive), not on Embree's traversal order.
  bool intersect(const Ray& ray, CoverageKey coverage_key, SurfaceHit* hit) const;

  // Returns the transmittance between `from` and `to`, both already offset from their surfaces. It
  // is 0 if something opaque lies between the two points, otherwise the product of 1 - coverage.
  // Values below 1/16 are randomly rounded to 1/16 or 0 (Russian roulette with `coverage_key`). The
  // expected value agrees with intersect().
  float transmittance(const Vec3f& from, const Vec3f& to, float time,
                      CoverageKey coverage_key) const;
  // Like transmittance(), but from `from` to infinity.
  float transmittance_to_infinity(const Vec3f& from, const Vec3f& direction, float time,
                                  CoverageKey coverage_key) const;

  // Returns whether the sampled emitter is hidden by a coincident emitter, which counts as being in
  // front of it (flush_emitters.h). Call this if transmittance() is not 0: the shadow ray ends
  // before both emitters, so it meets neither.
  bool is_behind_flush_emitter(const Vec3f& from, const LightSample& light, float time,
                               CoverageKey coverage_key) const;

  // Collects the faces between `from` and `from` + length * direction, at most out.size() of them,
  // in any order; returns their number. The device must have query filters
  // (EmbreeDevice::has_query_filters).
  size_t faces_along(const Vec3f& from, const Vec3f& direction, float length, float time,
                     CoverageKey coverage_key, std::span<CrossedFace> out) const;

  // Returns whether some material has alpha. Only then do the functions above use coverage keys.
  bool has_coverage() const { return has_coverage_; }
  // Returns whether some material transmits light.
  bool is_transmissive() const { return is_transmissive_; }
  // Returns whether some transmissive material may be a smooth thin wall
  // (Material::is_smooth_wall).
  bool has_smooth_walls() const { return has_smooth_walls_; }
  bool has_smooth_solids() const { return has_smooth_solids_; }  // Material::is_smooth_solid

  bool moves(uint32_t instance) const;
  // Returns whether at shutter open the bounding box of some face of this instance intersects
  // `box`.
  bool has_faces_near(uint32_t instance, const Imath::Box3f& box) const;
  // Returns null if the scene has no solids.
  const Solids* solids() const { return solids_.get(); }

  // Returns whether anything moves or changes during the shutter, so that the ray's time matters.
  bool moves() const { return moves_; }

  // Prefetch the memory that interaction() reads: first the triangle and, once it has arrived, its
  // vertices.
  void prefetch_triangle(const SurfaceHit& hit) const;
  void prefetch_vertices(const SurfaceHit& hit) const;
  // Computes the shading data of a hit; `time` is the ray's time.
  void interaction(const SurfaceHit& hit, float time, SurfaceInteraction* out) const;

  // The positions of the hit point in internal space at shutter open and at shutter close. With an
  // instant shutter, they are the positions at the rendered instant and one frame later.
  struct Motion {
    Vec3d from, to;
  };
  Motion motion_of(const SurfaceHit& hit) const;

  static constexpr uint32_t kNoEmitter = 0xffffffffu;
  // Returns the light sampler's index for a hit triangle, or kNoEmitter if the triangle is no
  // emitter.
  uint32_t emitter_index(uint32_t instance, uint32_t primitive) const {
    const uint32_t first = instances_[instance].first_emitter;
    return first == kNoEmitter ? kNoEmitter : first + primitive;
  }
  SurfaceAttributes emitter_attributes(const EmissiveTriangle& triangle, float time,
                                       const Vec2f& barycentric) const;
  const Material& material_of(uint32_t instance) const;
  uint32_t material_index_of(uint32_t instance) const;  // as in SurfaceInteraction
  // Returns whether the first set of texture coordinates exists and was kept
  // (SceneBuildOptions::unread_uv).
  bool has_uv(uint32_t instance) const;
  // Returns SurfaceInteraction::offset, which is the same for all points of a triangle.
  float surface_offset(uint32_t instance, uint32_t primitive, float time) const;

  const LightSampler& lights() const { return *lights_; }

  const Vec3d& origin() const { return origin_; }
  double scale() const { return scale_; }
  // Returns the limit on the coordinates of ray origins and targets in internal space: Embree must
  // be able to transform them into every instance's space.
  double max_origin() const { return max_origin_; }
  float radius() const { return radius_; }  // of the geometry's bounds, in internal space
  uint64_t triangle_count() const { return triangle_count_; }
  size_t instance_count() const { return instances_.size(); }

  const SceneMemory& memory() const { return memory_; }
  // Returns the number of BVHs built over the scene's geometry so far: one per instanced mesh, one
  // for the top level and, in a posable scene, one for the static group. Updates build no BVHs;
  // each pose adds the BVHs that it builds. The separate BVH of flush emitters is not counted.
  uint32_t bvh_builds() const;
  // Returns the keys of the meshes that the next pose can take over (MeshDescription::key),
  // ascending.
  std::vector<uint64_t> mesh_keys() const;
  // Returns short phrases for the report that say what was built and why.
  const std::vector<std::string>& features() const { return features_; }

 private:
  friend class EmptyPixels;
  friend class SceneBuilder;
  friend class SceneUpdater;
  friend class Solids;
  Scene();
  // Returns this scene as the interface from which the lights get the positions of moving emitters.
  const EmitterMotion& emitter_motion() const { return *this; }
  std::array<Vec3f, 3> corners(const EmissiveTriangle& triangle, float time) const override;
  int segments(const EmissiveTriangle& triangle) const override;
  bool visibility(const EmissiveTriangle& triangle, float time) const override;
  // Returns the instance itself if it is at rest; otherwise sets `moved` to the instance's state at
  // `time` and returns `moved`.
  const scene_detail::Instance& instance_at(uint32_t index, float time,
                                            scene_detail::Instance* moved) const {
    const scene_detail::Instance& instance = instances_[index];
    return instance.moving_index == scene_detail::Instance::kStatic
               ? instance
               : moved_instance(instance, time, moved);
  }
  const scene_detail::Instance& moved_instance(const scene_detail::Instance& instance, float time,
                                               scene_detail::Instance* moved) const;
  float offset_of(const scene_detail::Instance& instance, uint32_t index, uint32_t primitive,
                  float time) const;
  void resolve_flush_emitter(const Ray& ray, CoverageKey coverage_key, SurfaceHit* hit) const;
  Vec3d position_at(const SurfaceHit& hit, float time) const;
  Vec3d next_frame_position(const scene_detail::NextFramePlacement& next_frame,
                            const SurfaceHit& hit) const;
  void interpolate(const scene_detail::Mesh& mesh, const scene_detail::Instance& instance,
                   const SurfaceHit& hit, float time, SurfaceInteraction& out) const;

  std::vector<scene_detail::Mesh> meshes_;
  std::vector<scene_detail::Instance> instances_;
  std::vector<scene_detail::NextFramePlacement> next_frame_;  // ascending by instance
  scene_detail::InstanceVisibility visibility_;
  std::unique_ptr<scene_detail::Geometry> geometry_;
  std::unique_ptr<MaterialSet> materials_;
  std::shared_ptr<EnvironmentLight> environment_;  // also in lights_, unless it is black
  std::unique_ptr<LightSampler> lights_;
  std::unique_ptr<scene_detail::FlushEmitters> flush_;  // null if there are none
  std::unique_ptr<const Solids> solids_;
  bool has_coverage_ = false;
  bool is_transmissive_ = false;
  bool has_smooth_walls_ = false, has_smooth_solids_ = false;
  bool moves_ = false;
  Vec3d origin_ = Vec3d(0.0);
  double scale_ = 1.0;
  double max_origin_ = kMaxOrigin;
  float radius_ = 0.0f;
  uint64_t triangle_count_ = 0;
  SceneMemory memory_;
  std::vector<std::string> features_;
};

}  // namespace emberline
