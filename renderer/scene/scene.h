// What this frame needs of a scene, ready to be traced: geometry in an Embree BVH, compiled
// materials, the light sampler. Built by build_scene; immutable and thread-safe afterwards, but for
// update_scene where it was built for that.
//
// Internal space: internal = (world - origin()) * scale(). A scene far from the world's origin is
// moved there in double precision before it is rounded to float; one of extreme size is scaled by
// a power of two, which is exact. Callers that show lengths to people divide by scale().
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

// Closest intersection, as Embree found it.
struct SurfaceHit {
  float t = 0.0f;
  float u = 0.0f, v = 0.0f;  // barycentric weights of the triangle's second and third vertex
  uint32_t instance = 0;     // index of the placed mesh
  uint32_t primitive = 0;    // triangle in the mesh
};

// The hit point with all that shading asks for.
struct SurfaceInteraction {
  Vec3f position;
  // Rays that leave start at position +- offset * geometric_normal: an upper bound of the
  // position's distance from the plane that Embree will test. See offset_ray_origin.
  float offset = 0.0f;
  Vec3f geometric_normal;  // unit, front side of the triangle
  Vec3f shading_normal;    // interpolated, front side; unit (the geometric one if unusable)
  // xyz world, w handedness; 0 if the mesh has none. It and the colour are only there where the
  // material reads them (Material::reads_attributes).
  Vec4f tangent;
  SurfaceAttributes attributes{SurfaceAttributes::Unread{}};
  uint32_t instance = 0;
  uint32_t primitive = 0;
  const Material* material = nullptr;
  uint32_t material_index = 0;  // in the description; the default material comes after the last
};

// Moves a ray's origin off the surface to the side `direction` goes to. The distance is an error
// bound, not a tuned epsilon: 4 ulp of the largest coordinate that entered the computation.
[[gnu::always_inline]] inline Vec3f offset_ray_origin(const Vec3f& position,
                                                      const Vec3f& geometric_normal, float offset,
                                                      const Vec3f& direction) {
  return fma(geometric_normal, dot(direction, geometric_normal) < 0.0f ? -offset : offset,
             position);
}

// A face that a short way goes through.
struct CrossedFace {
  SurfaceHit hit;     // t is along that way
  bool back = false;  // the way comes from behind: out of a solid
};

// What a built scene holds. Only materials that a placed mesh has count; only their images are
// kept.
struct SceneMemory {
  uint64_t geometry_bytes = 0;  // vertices, indices, attributes, instances, emitters, light BVH
  uint64_t bvh_bytes = 0;       // what Embree holds: its memory monitor, and embree_api.h's sizes
  uint64_t texture_bytes = 0;   // resident texels, each image once; environment and its tables
  uint64_t texture_file_bytes = 0;  // texels that lie in a file instead (LoadLimits)
};

class Solids;

namespace scene_detail {

// Per instance, when it is there; null: always. Empty if all always are.
using ShownInstances = std::vector<std::shared_ptr<const ShownTimes>>;

// A mesh as the boundary of a solid, in its own space; see solids.h.
struct SolidShape {
  bool closed = false;
  double volume = 0.0;  // enclosed; of an open mesh meaningless
  Imath::Box3f bounds;  // over the whole shutter
};

struct GeometryRecord;  // what the BVH's filter knows of a mesh
struct OwnedScene;      // an Embree scene

// A mesh's arrays, in object space if it is instanced, else in internal space; and what Embree made
// of them. Where the scene is posed anew they go over to the next one as they are. `positions` has
// a spare entry at the end: Embree reads 16 bytes per vertex. `later` is in object space, as
// LaterPlace has it; empty: as `positions`.
struct KeptMesh : MeshArrays {
  std::optional<SolidShape> solid;  // once it has been asked for
  bool is_baked = false;
  std::shared_ptr<GeometryRecord> record;  // null without a filter
  std::shared_ptr<const OwnedScene> bvh;   // of an instanced mesh
};

struct Mesh : KeptMesh {
  const Material* material = nullptr;
  uint32_t material_index = 0;
  bool cull_backfaces = false;
  bool culling_may_change = false;  // by an update, as may the coverage
  bool coverage_may_change = false;
  // Whether the material reads what interpolate_attributes finds.
  bool has_attributes = false;
  bool has_coverage = false;
  const ShownInstances* shown = nullptr;  // where some instance of it is not always there
};

// Row-vector affine transform, the very floats Embree is given.
struct Affine {
  Vec3f x, y, z, translation;
  bool operator==(const Affine&) const = default;
};

struct Instance {
  uint32_t mesh = 0;
  bool transformed = false;  // false: the mesh is already in internal space
  bool mirrored = false;
  uint32_t first_emitter = 0xffffffffu;  // index of triangle 0's emitter, if the mesh emits
  // Of Geometry's moving instances; the transform is then the one at the shutter's opening.
  uint32_t moving = kAtRest;
  static constexpr uint32_t kAtRest = 0xffffffffu;
  Affine to_internal;
  Affine normal_transform;  // inverse transpose, rows; translation unused
};

// Where what moves is a frame after the instant that is rendered (LaterInstance).
struct LaterPlace {
  uint32_t instance = 0;
  // To internal space from the mesh's `later`; where that is empty, from its `positions`.
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

  // Closest surface along the ray. Back faces of single-sided materials and the holes of alpha
  // coverage do not count; stochastic coverage is decided by (coverage_key, instance, primitive),
  // so the answer does not depend on the order in which Embree visits them.
  bool intersect(const Ray& ray, CoverageKey coverage_key, SurfaceHit* hit) const;

  // What gets from `to` to `from` (both already offset from their surfaces): 0 where something lies
  // between, else the product of 1 - coverage. Where that is below 1/16 it is 1/16 or 0, as
  // `coverage_key` decides; the expectation is that of intersect() throughout.
  float transmittance(const Vec3f& from, const Vec3f& to, float time,
                      CoverageKey coverage_key) const;
  // The same from infinity.
  float transmittance_to_infinity(const Vec3f& from, const Vec3f& direction, float time,
                                  CoverageKey coverage_key) const;

  // Whether a point sampled on an emitter lies in another emitter that counts as being in front of
  // it: asked where `transmittance` is not 0, since that ray ends before both. See
  // flush_emitters.h.
  bool behind_flush_emitter(const Vec3f& from, const LightSample& light, float time,
                            CoverageKey coverage_key) const;

  // The faces between `from` and `from` + length * direction, `out`.size() at most, in no order;
  // returns their number. Of a scene whose device takes filters.
  size_t faces_along(const Vec3f& from, const Vec3f& direction, float length, float time,
                     CoverageKey coverage_key, std::span<CrossedFace> out) const;

  // Whether coverage keys matter: some material has alpha.
  bool has_coverage() const { return has_coverage_; }
  // Whether some material lets light pass.
  bool passes_light() const { return passes_light_; }
  // Whether some of that may be smooth thin walls (Material::is_smooth_wall).
  bool has_smooth_walls() const { return has_smooth_walls_; }
  bool has_smooth_solids() const { return has_smooth_solids_; }  // Material::is_smooth_solid

  bool moves(uint32_t instance) const;
  // Whether the bounds of some face of an instance come into the box, at the shutter's opening.
  bool has_faces_near(uint32_t instance, const Imath::Box3f& box) const;
  // Null if there are none.
  const Solids* solids() const { return solids_.get(); }

  // Whether something in it moves or changes, so that rays of other times see something else.
  bool moves() const { return moves_; }

  // Ask for the memory that interaction() will wait for: the triangle's, and when that is there its
  // vertices'.
  void prefetch_triangle(const SurfaceHit& hit) const;
  void prefetch_vertices(const SurfaceHit& hit) const;
  // `time`: of the ray that hit.
  void interaction(const SurfaceHit& hit, float time, SurfaceInteraction* out) const;

  // Where a point that was hit is as the shutter opens, and as it closes; of an instant, then and a
  // frame later. Internal space.
  struct Way {
    Vec3d from, to;
  };
  Way way_of(const SurfaceHit& hit) const;

  static constexpr uint32_t kNoEmitter = 0xffffffffu;
  // The light sampler's index of a hit triangle, or kNoEmitter.
  uint32_t emitter_index(uint32_t instance, uint32_t primitive) const {
    const uint32_t first = instances_[instance].first_emitter;
    return first == kNoEmitter ? kNoEmitter : first + primitive;
  }
  // Attributes of a point sampled on a light.
  SurfaceAttributes emitter_attributes(const EmissiveTriangle& triangle, float time,
                                       const Vec2f& barycentric) const;
  const Material& material_of(uint32_t instance) const;
  uint32_t material_index_of(uint32_t instance) const;  // as in SurfaceInteraction
  // Whether the first texture coordinates were given, and kept (SceneBuildOptions::unread_uv).
  bool has_uv(uint32_t instance) const;
  // `offset` of SurfaceInteraction for any point of a triangle.
  float surface_offset(uint32_t instance, uint32_t primitive, float time) const;

  const LightSampler& lights() const { return *lights_; }

  const Vec3d& origin() const { return origin_; }
  double scale() const { return scale_; }
  // Coordinates of points, internal, that rays may start from or go to: Embree takes them into the
  // space of every instance.
  double farthest() const { return farthest_; }
  float radius() const { return radius_; }  // internal, of the geometry's bounds
  uint64_t triangle_count() const { return triangle_count_; }
  size_t instance_count() const { return instances_.size(); }

  const SceneMemory& memory() const { return memory_; }
  // How often a BVH over the scene's geometry was built: one per instanced mesh and one over all;
  // in a scene that can be posed one over what stays in its place besides. No update adds to it,
  // and a pose what it builds. (Emitters that lie in other surfaces have one of their own besides.)
  uint32_t bvh_builds() const;
  // The meshes that the next pose may leave to it (MeshDescription::key), in growing order.
  std::vector<uint64_t> mesh_keys() const;
  // What was built and why, a phrase each, for the report.
  const std::vector<std::string>& features() const { return features_; }

 private:
  friend class EmptyPixels;
  friend class SceneBuilder;
  friend class SceneUpdater;
  friend class Solids;
  Scene();
  // Where emitters that move are.
  const EmitterMotion& emitter_motion() const { return *this; }
  std::array<Vec3f, 3> corners(const EmissiveTriangle& triangle, float time) const override;
  int segments(const EmissiveTriangle& triangle) const override;
  bool shown(const EmissiveTriangle& triangle, float time) const override;
  // The instance itself where it is at rest; else `moved`, which becomes it at that time.
  const scene_detail::Instance& instance_at(uint32_t index, float time,
                                            scene_detail::Instance* moved) const {
    const scene_detail::Instance& instance = instances_[index];
    return instance.moving == scene_detail::Instance::kAtRest
               ? instance
               : moved_instance(instance, time, moved);
  }
  const scene_detail::Instance& moved_instance(const scene_detail::Instance& instance, float time,
                                               scene_detail::Instance* moved) const;
  float offset_of(const scene_detail::Instance& instance, uint32_t index, uint32_t primitive,
                  float time) const;
  void prefer_flush_emitter(const Ray& ray, CoverageKey coverage_key, SurfaceHit* hit) const;
  Vec3d place_at(const SurfaceHit& hit, float time) const;
  Vec3d place_later(const scene_detail::LaterPlace& later, const SurfaceHit& hit) const;
  void interpolate(const scene_detail::Mesh& mesh, const scene_detail::Instance& instance,
                   const SurfaceHit& hit, float time, SurfaceInteraction& out) const;

  std::vector<scene_detail::Mesh> meshes_;
  std::vector<scene_detail::Instance> instances_;
  std::vector<scene_detail::LaterPlace> later_;  // by growing instance
  scene_detail::ShownInstances shown_;
  std::unique_ptr<scene_detail::Geometry> geometry_;
  std::unique_ptr<MaterialSet> materials_;
  std::shared_ptr<EnvironmentLight> environment_;  // lights_ holds it too, unless it is black
  std::unique_ptr<LightSampler> lights_;
  std::unique_ptr<scene_detail::FlushEmitters> flush_;  // null without any
  std::unique_ptr<const Solids> solids_;
  bool has_coverage_ = false;
  bool passes_light_ = false;
  bool has_smooth_walls_ = false, has_smooth_solids_ = false;
  bool moves_ = false;
  Vec3d origin_ = Vec3d(0.0);
  double scale_ = 1.0;
  double farthest_ = kFarthestOrigin;
  float radius_ = 0.0f;
  uint64_t triangle_count_ = 0;
  SceneMemory memory_;
  std::vector<std::string> features_;
};

}  // namespace emberline
