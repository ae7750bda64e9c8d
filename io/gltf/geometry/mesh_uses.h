// The meshes of a scene graph, in the poses that its nodes wear them in: loaded in parallel, or
// known from the pose before.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "io/gltf/animation/rest.h"
#include "io/gltf/document/document.h"
#include "io/gltf/geometry/mesh.h"
#include "renderer/description/scene_description.h"

namespace emberline {

// A mesh in one pose, or in motion, or in one pose and a later one; all its primitives.
struct MeshUse {
  size_t mesh = 0;
  std::vector<MeshPose> poses;
  uint64_t placements = 0;
  int skin = -1, node = -1;  // the node where it has weights of its own
  bool rests = false;        // no time deforms it
  bool may_move = false;     // MeshDescription's
  bool flat = false;         // load_primitive's
  // GltfMeshUses::center(), once it has been asked for.
  std::optional<Vec3d> center = {};
  std::vector<int> loaded;  // indices into SceneDescription::meshes
};

class GltfMeshUses {
 public:
  // `later`: as load_primitive has it. What `rest` knows is not read again, and what it may come to
  // know is added to it; of meshes whose keys are `held`, which grow, nothing is read. The
  // arguments outlive it.
  GltfMeshUses(const GltfDocument& document, bool later, std::span<const uint64_t> held,
               GltfRest& rest, SceneDescription& scene)
      : document_(document), later_(later), held_(held), rest_(rest), scene_(scene) {}

  // Adds them to the scene, which is posed or at rest. Throws InputError.
  void load(std::vector<MeshUse>& uses, bool at_rest);

  // Of a mesh of the scene: a ball around its origin.
  double radius(size_t mesh) const;
  // The middle of all its primitives, in its own space.
  Vec3d center(const MeshUse& use) const;
  // Placed, which have no surface.
  uint64_t points() const { return points_; }
  uint64_t lines() const { return lines_; }
  // Whether a skin or morph targets have left a primitive without area in this pose.
  bool collapsed() const { return collapsed_; }

 private:
  struct Primitive;
  void check_budget(std::span<const MeshUse> uses) const;
  uint64_t count_elements(const nlohmann::json& primitive, std::span<const MeshPose> poses) const;
  void load(Primitive& task) const;
  const RestMesh* know(Primitive& task);
  bool add(Primitive& task);
  void note_without_surface(const LoadedMesh& loaded, uint64_t placements);

  const GltfDocument& document_;
  const bool later_;
  const std::span<const uint64_t> held_;
  GltfRest& rest_;
  SceneDescription& scene_;
  std::vector<const RestMesh*> resting_;  // per mesh of the scene; null: it deforms
  uint64_t points_ = 0, lines_ = 0;
  bool collapsed_ = false;
};

}  // namespace emberline
