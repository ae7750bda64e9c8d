// The poses of skinned and morphed meshes while the shutter is open.
#pragma once

#include <map>
#include <vector>

#include "io/gltf/animation/shutter.h"
#include "io/gltf/geometry/mesh.h"

namespace emberline {

// The joint matrices are relative to `origin`, the first joint's position at shutter opening.
// `origin` is in double, for scenes far from the world's origin.
struct SkinPose {
  Vec3d origin;
  std::vector<std::vector<Mat44d>> joints;  // per step; only the first if no joint moves
};

class GltfPoses {
 public:
  // The arguments must outlive this object. Returned references are valid as long as this object
  // exists.
  GltfPoses(const GltfDocument& document, const GltfShutter& shutter);

  // morphs() tells whether the mesh has morph targets. has_own_weights() tells whether the node's
  // weights are animated or differ from the mesh's weights.
  bool morphs(size_t mesh) const { return defaults_[mesh].morphs; }
  bool has_own_weights(size_t node) const;
  // Loads the skin on first use. Throws InputError.
  const SkinPose& skin(int index);
  const SkinPose& loaded_skin(int index) const { return skins_.at(index); }
  // Returns the poses of the node's mesh: just enough that vertices can move linearly between them.
  // Throws InputError.
  std::vector<MeshPose> mesh_poses(size_t node);

 private:
  // Whether a mesh has morph targets, and its default weights, for nodes without their own weights.
  struct MorphDefaults {
    bool morphs = false;
    std::vector<double> weights;
  };
  static MorphDefaults morph_defaults(const nlohmann::json& mesh);
  const std::vector<double>& weights_of(size_t node, size_t step) const;

  const GltfDocument& document_;
  const GltfShutter& shutter_;
  std::vector<MorphDefaults> defaults_;  // per mesh
  std::map<int, SkinPose> skins_;        // skins used by nodes
  MemoryReservation memory_;
};

}  // namespace emberline
