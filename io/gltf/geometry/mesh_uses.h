// Loads the meshes of a scene graph in parallel, in the poses in which nodes use them. Reuses
// meshes of the previous pose.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "io/gltf/animation/cache.h"
#include "io/gltf/document/document.h"
#include "io/gltf/geometry/mesh.h"
#include "renderer/description/scene_description.h"

namespace emberline {

// A mesh (with all its primitives) in one pose, in several poses of a motion, or in the poses of
// the current and the next frame.
struct MeshUse {
  size_t mesh = 0;
  std::vector<MeshPose> poses;
  uint64_t placements = 0;
  int skin = -1, node = -1;  // node: -1 unless the node has its own weights
  bool undeformed = false;   // whether no animation deforms the mesh
  bool may_move = false;     // MeshDescription::may_move
  bool flat = false;         // passed to load_primitive()
  // Cached result of GltfMeshUses::center().
  std::optional<Vec3d> center = {};
  std::vector<int> loaded;  // indices into SceneDescription::meshes
};

class GltfMeshUses {
 public:
  // `next_frame` means the same as in load_primitive(). Undeformed meshes are added to `cache`.
  // `held` (ascending) lists the keys of cached meshes that the caller still has; these are not
  // read again. All arguments must outlive this object.
  GltfMeshUses(const GltfDocument& document, bool next_frame, std::span<const uint64_t> held,
               GltfCache& cache, SceneDescription& scene)
      : document_(document), next_frame_(next_frame), held_(held), cache_(cache), scene_(scene) {}

  // Adds the meshes to the scene. Throws InputError.
  void load(std::vector<MeshUse>& uses, bool at_rest);

  // Radius of a ball around the origin that contains the scene's mesh with this index.
  double radius(size_t mesh) const;
  // Centre of the bounds of all the mesh's primitives, in mesh space.
  Vec3d center(const MeshUse& use) const;
  // Number of points and of lines that nodes place in the scene. Points and lines are not rendered.
  uint64_t points() const { return points_; }
  uint64_t lines() const { return lines_; }
  // Whether deformation has left a primitive without area in this pose.
  bool collapsed() const { return collapsed_; }

 private:
  struct Primitive;
  void check_budget(std::span<const MeshUse> uses) const;
  uint64_t count_elements(const nlohmann::json& primitive, std::span<const MeshPose> poses) const;
  void load(Primitive& task) const;
  const StaticMesh* cache_mesh(Primitive& task);
  bool add(Primitive& task);
  void count_surfaceless(const LoadedMesh& loaded, uint64_t placements);

  const GltfDocument& document_;
  const bool next_frame_;
  const std::span<const uint64_t> held_;
  GltfCache& cache_;
  SceneDescription& scene_;
  std::vector<const StaticMesh*> static_meshes_;  // for each mesh of the scene; null if it deforms
  uint64_t points_ = 0, lines_ = 0;
  bool collapsed_ = false;
};

}  // namespace emberline
