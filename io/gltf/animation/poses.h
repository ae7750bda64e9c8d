// What skins and morph weights make of meshes while the shutter is open.
#pragma once

#include <map>
#include <vector>

#include "io/gltf/animation/shutter.h"
#include "io/gltf/geometry/mesh.h"

namespace emberline {

// The first joint's position as the shutter opens is kept apart in double, for scenes far from the
// origin; the joints' matrices lead to a space around it.
struct SkinPose {
  Vec3d origin;
  std::vector<std::vector<Mat44d>> joints;  // of each step; of the first alone, if none moves
};

class GltfPoses {
 public:
  // The arguments outlive it, and it what it returns.
  GltfPoses(const GltfDocument& document, const GltfShutter& shutter);

  // Whether the mesh has targets; and whether their weights are animated, or others than the
  // mesh's, where the node wears it.
  bool morphs(size_t mesh) const { return defaults_[mesh].morphs; }
  bool has_own_weights(size_t node) const;
  // Read when it is first asked for. Throws InputError.
  const SkinPose& skin(int index);
  const SkinPose& known_skin(int index) const { return skins_.at(index); }
  // Of a node's mesh: as many as it takes for vertices that go straight from one to the next to
  // stay where they should. Throws InputError.
  std::vector<MeshPose> of(size_t node);

 private:
  // What the file says of a mesh's targets: the weights of nodes that have none of their own.
  struct MorphDefaults {
    bool morphs = false;
    std::vector<double> weights;
  };
  static MorphDefaults morph_defaults(const nlohmann::json& mesh);
  const std::vector<double>& weights_of(size_t node, size_t step) const;

  const GltfDocument& document_;
  const GltfShutter& shutter_;
  std::vector<MorphDefaults> defaults_;  // per mesh
  std::map<int, SkinPose> skins_;        // those that nodes wear
  MemoryReservation memory_;
};

}  // namespace emberline
