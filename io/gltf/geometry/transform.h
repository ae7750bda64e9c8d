// Node transforms in double precision. They are for row vectors: p' = p * M.
#pragma once

#include <optional>

#include "io/gltf/animation/animation.h"
#include "io/gltf/document/document.h"
#include "renderer/core/vector.h"

namespace emberline {

// Returns the world matrix of every node in a pose, whether the node is in the scene or not. If the
// matrix of a node is not finite or is too large for float, notes the node and its descendants as
// broken.
std::vector<Mat44d> world_transforms(const GltfDocument& document, const GltfPose& pose);

// Returns the transform of one node relative to its parent.
Mat44d local_transform(const GltfDocument& document, size_t node, const GltfPose& pose);

// Applies the scale, then the rotation (a quaternion x, y, z, w; normalised here), then the
// translation.
Mat44d compose_transform(const Vec3d& translation, const Quaternion& rotation, const Vec3d& scale);

// True if the upper 3x3 has no usable inverse.
bool is_singular(const Mat44d& m);

// Returns the unit direction that a singular transform maps to 0, or nothing if the transform
// collapses space to a line or a point.
std::optional<Vec3d> flattened_axis(const Mat44d& m);
// `flat` maps space to a plane. Returns an invertible transform that maps `axis` to the plane's
// normal, with a length of `thickness` times the size in the plane. `center` stays in the plane. If
// `mirrored`, the determinant is negative.
Mat44d thickened(const Mat44d& flat, const Vec3d& axis, double thickness,
                 const Vec3d& center = Vec3d(0.0), bool mirrored = false);
// Returns a transform that first projects along `axis` onto the plane through `center` and then
// applies `m`.
Mat44d flattened(const Mat44d& m, const Vec3d& axis, const Vec3d& center);
// Makes a flat transform invertible, so that it can orient a camera or light. Returns an invertible
// transform unchanged. Returns nothing if the transform collapses space to a line or a point.
std::optional<Mat44d> restore_directions(const Mat44d& m);

// Returns a transform that places a camera or light at the node, whose world transform is `world`.
// It keeps the directions of the node's -Z and +Y even if scales of the node or its ancestors are
// 0. Returns nothing if a matrix of the node or an ancestor destroys the directions.
std::optional<Mat44d> aimed_transform(const GltfDocument& document, size_t node,
                                      const GltfPose& pose, const Mat44d& world);

// Throws InputError unless every element is finite and small enough to square in float.
void check_transform(const Mat44d& m, const std::string& place);

}  // namespace emberline
