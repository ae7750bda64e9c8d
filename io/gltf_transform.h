// Node transforms in double precision. Row vectors: p' = p * M.
#pragma once

#include "io/gltf_animation.h"
#include "io/gltf_document.h"
#include "io/tiny_gltf_forward.h"
#include "renderer/core/vector.h"

namespace emberline {

// World matrix of every node, in or outside the scene, in a pose. Where one is not finite or too
// large for float, the node and those below it are noted as broken.
std::vector<Mat44d> world_transforms(const GltfDocument& document, const tinygltf::Model& model,
                                     const GltfPose& pose);

// Of one node, relative to its parent.
Mat44d local_transform(const GltfDocument& document, const tinygltf::Model& model, size_t node,
                       const GltfPose& pose);

// scale, then rotation (unit quaternion x, y, z, w; normalised here), then translation.
Mat44d compose_transform(const Vec3d& translation, const Quaternion& rotation, const Vec3d& scale);

// True when the upper 3x3 has no usable inverse.
bool is_singular(const Mat44d& m);

// Throws InputError unless every element is finite and within what float can square.
void check_transform(const Mat44d& m, const std::string& place);

}  // namespace emberline
