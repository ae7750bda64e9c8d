// The meshes of a scene in a pose: read, or known from a pose before.
#pragma once

#include <span>
#include <vector>

#include "io/gltf_document.h"
#include "io/gltf_mesh.h"
#include "io/gltf_rest.h"
#include "renderer/description/scene_description.h"

namespace emberline {

// A mesh in one pose, or in motion; all its primitives.
struct MeshUse {
  size_t mesh = 0;
  std::vector<MeshPose> poses;
  uint64_t placements = 0;
  int skin = -1, node = -1;      // the node where it has weights of its own
  bool rests = false;            // no time deforms it
  std::vector<int> loaded = {};  // indices into SceneDescription::meshes
};

// All meshes of a pose. What rests is read once.
class GltfMeshLoader {
 public:
  // The arguments outlive it. `held`, growing: keys of meshes that are not read.
  GltfMeshLoader(const GltfDocument& document, bool at_rest, std::span<const uint64_t> held,
                 GltfRest& rest, SceneDescription& scene)
      : document_(document), at_rest_(at_rest), held_(held), rest_(rest), scene_(scene) {}

  // Into the scene's meshes, in the order of the uses, with what there is to say of them; notes in
  // `uses` which they are. `may_move`, per mesh of the file: MeshDescription's. In parallel. Throws
  // InputError, the first in file order.
  void load(std::vector<MeshUse>& uses, const std::vector<char>& may_move);
  // Of a ball around the origin of a mesh of the scene.
  double radius_of(int mesh) const;
  uint64_t points() const { return points_; }  // placed, which have no surface
  uint64_t lines() const { return lines_; }

 private:
  struct Primitive;
  void check_budget(std::span<const MeshUse> uses) const;
  uint64_t count_elements(const nlohmann::json& primitive, std::span<const MeshPose> poses) const;
  void read(Primitive& task) const;
  const RestMesh* know(Primitive& task);
  bool add(Primitive& task);
  void note_without_surface(const LoadedMesh& loaded, uint64_t placements);

  const GltfDocument& document_;
  const bool at_rest_;
  const std::span<const uint64_t> held_;
  GltfRest& rest_;
  SceneDescription& scene_;
  std::vector<const RestMesh*> resting_;  // per mesh of scene_; null: it deforms
  uint64_t points_ = 0, lines_ = 0;
};

}  // namespace emberline
