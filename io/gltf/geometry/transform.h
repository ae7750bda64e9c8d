// Node transforms in double precision. Row vectors: p' = p * M.
#pragma once

#include <optional>

#include "io/gltf/animation/animation.h"
#include "io/gltf/document/document.h"
#include "renderer/core/vector.h"

namespace emberline {

// World matrix of every node, in or outside the scene, in a pose. Where one is not finite or too
// large for float, the node and those below it are noted as broken.
std::vector<Mat44d> world_transforms(const GltfDocument& document, const GltfPose& pose);

// Of one node, relative to its parent.
Mat44d local_transform(const GltfDocument& document, size_t node, const GltfPose& pose);

// scale, then rotation (unit quaternion x, y, z, w; normalised here), then translation.
Mat44d compose_transform(const Vec3d& translation, const Quaternion& rotation, const Vec3d& scale);

// True when the upper 3x3 has no usable inverse.
bool is_singular(const Mat44d& m);

// The unit direction that a singular transform takes to nothing. None where there are several, so
// that the transform leaves a line or a point.
std::optional<Vec3d> flattened_axis(const Mat44d& m);
// A transform that differs from a flat one in that the direction becomes the normal of its plane,
// at that share of the size that things have in the plane. `center` stays in the plane; with
// `mirrored` the determinant is negative.
Mat44d thickened(const Mat44d& flat, const Vec3d& axis, double thickness,
                 const Vec3d& center = Vec3d(0.0), bool mirrored = false);
// A transform after one that has put everything into the plane through the center, along the axis.
Mat44d flattened(const Mat44d& m, const Vec3d& axis, const Vec3d& center);
// What a camera or a lamp sees of a flat transform: it keeps its directions. Other transforms are
// returned as they are; none without directions.
std::optional<Mat44d> with_directions(const Mat44d& m);

// Where a node's -Z and +Y point, whatever scales are 0 on the way to it; at its place. None where
// a matrix leaves no directions.
std::optional<Mat44d> aimed_transform(const GltfDocument& document, size_t node,
                                      const GltfPose& pose, const Mat44d& world);

// Throws InputError unless every element is finite and within what float can square.
void check_transform(const Mat44d& m, const std::string& place);

}  // namespace emberline
