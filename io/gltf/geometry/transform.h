// Node transforms in double precision. Row vectors: p' = p * M.
#pragma once

#include <optional>

#include "io/gltf/animation/animation.h"
#include "io/gltf/document/document.h"
#include "renderer/core/vector.h"

namespace emberline {

// World matrix of every node in a pose, whether in the scene or not. A node whose matrix is not
// finite or too large for float is noted as broken, with its descendants.
std::vector<Mat44d> world_transforms(const GltfDocument& document, const GltfPose& pose);

// Transform of one node relative to its parent.
Mat44d local_transform(const GltfDocument& document, size_t node, const GltfPose& pose);

// Scale, then rotation (quaternion x, y, z, w; normalised here), then translation.
Mat44d compose_transform(const Vec3d& translation, const Quaternion& rotation, const Vec3d& scale);

// True if the upper 3x3 has no usable inverse.
bool is_singular(const Mat44d& m);

// The unit direction that a singular transform maps to 0; nothing if its image is a line or a
// point.
std::optional<Vec3d> flattened_axis(const Mat44d& m);
// Makes a flat transform invertible: `axis` is mapped to the normal of its plane, scaled by
// `thickness` times the size in the plane. `center` stays in the plane; with `mirrored` the
// determinant is negative.
Mat44d thickened(const Mat44d& flat, const Vec3d& axis, double thickness,
                 const Vec3d& center = Vec3d(0.0), bool mirrored = false);
// Transform `m` after flattening everything along `axis` to the plane through `center`.
Mat44d flattened(const Mat44d& m, const Vec3d& axis, const Vec3d& center);
// Makes a flat transform usable for a camera or light by restoring its directions. Returns other
// transforms unchanged, and nothing if no directions are left.
std::optional<Mat44d> restore_directions(const Mat44d& m);

// A transform at the node's position that keeps the directions of its -Z and +Y even if scales on
// the way are 0. Nothing if a matrix leaves no directions.
std::optional<Mat44d> aimed_transform(const GltfDocument& document, size_t node,
                                      const GltfPose& pose, const Mat44d& world);

// Throws InputError unless every element is finite and small enough to square in float.
void check_transform(const Mat44d& m, const std::string& place);

}  // namespace emberline
