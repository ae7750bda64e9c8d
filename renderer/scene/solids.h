// The scene's solids: instances whose material transmits light into an interior
// (Material::is_solid). They are found when the scene is built or updated; afterwards, the object
// is immutable and thread-safe.
#pragma once

#include <Imath/ImathBox.h>

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "renderer/core/vector.h"

namespace emberline {

class LoadProgress;
class MemoryReservation;
class Scene;
struct SceneDescription;
namespace scene_detail {
struct Mesh;
struct SolidShape;

// Returns the shape enclosed by one mesh or by several together. `meshes` must share one coordinate
// space and must have triangles. If `name` is given, warns about closed meshes that are inside out.
// Throws Cancelled.
SolidShape shape_of(std::span<const Mesh* const> meshes, const std::string* name,
                    LoadProgress& progress);
}  // namespace scene_detail

class Solids {
 public:
  // Returns null if the scene has no solid. Stores each mesh's shape in the mesh. `description`
  // provides names. Throws Cancelled.
  static std::unique_ptr<const Solids> find(Scene& scene, const SceneDescription& description,
                                            LoadProgress& progress);

  const std::vector<uint32_t>& instances() const { return instances_; }
  // Returns whether the solid's surface is closed: triangles use each edge equally often in both
  // directions. Several meshes of a node may form a closed surface together. Corners at the same
  // position count as one.
  bool closed(uint32_t instance) const { return solids_[instance].closed; }
  // Returns the body of an instance: the first of the instances that together form its closed
  // surface, or the instance itself. All parts of a closed body count as closed and contain the
  // same medium.
  uint32_t body(uint32_t instance) const {
    return parts_.empty() ? instance : solids_[instance].body;
  }
  bool has_joined_parts() const { return !parts_.empty(); }
  // Maps the instances of opaque surfaces that close a solid, such as a label on a bottle, to the
  // solid's body.
  const std::map<uint32_t, uint32_t>& opaque_parts() const { return opaque_parts_; }
  // Returns whether `a` rather than `b` fills a point that both closed solids enclose. The smaller
  // solid fills it, so that a solid inside another always takes effect. The rule depends only on
  // the point, not on the path that reaches it. This is the priority of C. Schmidt & B. Budge,
  // "Simple Nested Dielectrics in Ray Traced Images" (JGT 7(2), 2002), but it is derived from the
  // geometry.
  bool has_priority(uint32_t a, uint32_t b) const { return solids_[a].rank < solids_[b].rank; }
  // Returns whether a face may coincide with another face. A solid's face is compared with the
  // faces of other solids and of surfaces without an interior and, if the solid is flat, with its
  // own other faces. A face of a surface without an interior is compared only with faces of solids.
  bool may_coincide(uint32_t instance, uint32_t primitive) const {
    const std::vector<bool>& faces = solids_[instance].touching;
    return !faces.empty() && faces[primitive];
  }
  // Returns whether the solid is closed and the faces of all its parts lie in one plane. Such a
  // solid has no inside for a path and acts as a thin wall.
  bool is_flat(uint32_t instance) const { return solids_[instance].is_flat; }
  // Returns whether the solid's faces only refract light (Material::is_clear_solid).
  bool is_clear(uint32_t instance) const { return solids_[instance].is_clear; }
  // Returns whether light from outside all solids may pass straight through a face, because the
  // solid does not refract or is flat.
  bool transmits_straight(uint32_t instance) const { return solids_[instance].transmits_straight; }
  bool has_straight_transmission() const { return has_straight_transmission_; }
  // Returns whether some solids are so near to each other that they or their faces may overlap.
  bool has_near_solids() const { return !near_.empty(); }
  uint64_t touching_faces() const { return touching_faces_; }
  // Returns the bounds of the whole body in internal space. The scene must have its BVH.
  Imath::Box3f bounds_over_shutter(const Scene& scene, uint32_t instance) const;
  // Returns the mesh name of an open solid.
  const std::string& open_name(uint32_t instance) const { return open_names_.at(instance); }

 private:
  struct Solid {
    bool closed = false, is_near = false, is_flat = false, is_clear = false,
         transmits_straight = false;
    uint32_t rank = 0, body = 0;
    double volume = 0.0;
    // Bounds of the whole body, in object space and (at shutter open) in internal space.
    Imath::Box3f mesh_bounds, bounds;
    std::vector<bool> touching;  // by face: whether it touches another face; empty if no face does
  };
  struct Face;
  struct FaceList;
  struct StripFace;
  Solids() = default;
  void set_shape(const Scene& scene, uint32_t instance, const scene_detail::SolidShape& shape);
  void join_parts(const Scene& scene, const SceneDescription& description, LoadProgress& progress);
  void find_ranks();
  std::vector<uint32_t> parts_of(uint32_t body) const;
  void find_near();
  void find_flat(const Scene& scene);
  static std::vector<StripFace> sort_into_strips(const std::vector<Face>& faces,
                                                 const std::string& file,
                                                 MemoryReservation* memory);
  void find_touching(const Scene& scene, const std::string& file, LoadProgress& progress);
  Face face_of(const Scene& scene, uint32_t instance, uint32_t primitive) const;
  void add_faces(const Scene& scene, uint32_t instance, FaceList* faces) const;
  bool add_surfaces(const Scene& scene, LoadProgress& progress, FaceList* faces) const;
  static std::array<Vec3d, 3> corners_of(const Scene& scene, uint32_t instance, uint32_t primitive);
  static bool are_coplanar(const Scene& scene, const Face& a, const Face& b);
  void mark_touching(const Scene& scene, const Face& face);
  void mark_all_touching(const Scene& scene, uint32_t instance);

  std::vector<Solid> solids_;  // by instance
  std::vector<uint32_t> instances_;
  std::map<uint32_t, std::vector<uint32_t>> parts_;  // for bodies of several parts; includes opaque
                                                     // parts
  std::map<uint32_t, uint32_t> opaque_parts_;
  std::map<uint32_t, std::string> open_names_;
  std::vector<uint32_t> near_;  // solids that are near another solid
  uint64_t touching_faces_ = 0;
  bool has_straight_transmission_ = false;
};

}  // namespace emberline
