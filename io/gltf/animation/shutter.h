// Node transforms while the shutter is open. They are given at evenly spaced times (steps), as many
// as the motion needs. For an instant with motion vectors, there are two steps: the instant and the
// time of the next frame.
#pragma once

#include <vector>

#include "io/gltf/animation/animation.h"
#include "io/gltf/geometry/mesh.h"

namespace emberline {

class GltfShutter {
 public:
  // Both arguments must outlive this object. Throws InputError if there is not enough memory or if
  // a moving node's transform is not finite or too large.
  GltfShutter(const GltfDocument& document, const GltfAnimation& animation);

  // World transforms of all nodes at shutter opening.
  const std::vector<Mat44d>& world() const { return world_; }
  const GltfPose& pose(size_t step = 0) const { return poses_[step]; }

  // Bounds of the undeformed mesh, as its accessors state them; empty if the accessors state none.
  // The scene must not be at rest.
  const WorldBounds& bounds(size_t mesh) const { return bounds_[mesh]; }
  // Radius of a ball around the origin that contains the mesh; infinite if the bounds are unknown.
  double radius(size_t mesh) const;

  // Number of poses, including the first; 1 if nothing moves.
  size_t steps() const { return poses_.size(); }
  // Whether the shutter interval is an instant with motion vectors. If there is a second pose, it
  // is then the pose at the time GltfAnimation::next_frame.
  bool is_instant() const { return animation_.next_frame.has_value(); }
  bool moves(size_t node) const { return !moving_.empty() && moving_[node] != kNotMoving; }
  // Requires moves(node).
  const Mat44d& world(size_t node, size_t step) const { return motion_[step][moving_[node]]; }

 private:
  static constexpr uint32_t kNotMoving = ~0u;
  void find_moving_nodes();
  void sample_poses(size_t segments);
  bool is_fine_enough() const;
  bool flips_handedness(size_t i) const;
  double node_radius(size_t i) const;  // `i` indexes order_

  const GltfDocument& document_;
  const GltfAnimation& animation_;
  const double open_, close_;
  std::vector<WorldBounds> bounds_;  // per mesh
  std::vector<GltfPose> poses_;
  std::vector<Mat44d> world_;
  std::vector<uint32_t> moving_;             // per node: its index in motion_
  std::vector<size_t> order_;                // moving nodes, parents first
  std::vector<std::vector<Mat44d>> motion_;  // per step, for the nodes of order_
  MemoryReservation memory_;
};

// Thickness of a flattened object, relative to its size in the plane. The thickness keeps the front
// side in front of the back side, but is too small to see. The value is our choice.
inline constexpr double kThickness = 4e-6;

// Makes all steps invertible. A flattened object gets thickness kThickness around `center`. An
// object scaled to zero gets the transform of the nearest invertible step, scaled by 1/10000.
// Returns an empty list if no step is invertible.
std::vector<Mat44d> make_invertible(std::vector<Mat44d> steps, const Vec3d& center);

// Keeps only as many evenly spaced steps as are needed. If vertices move linearly between the kept
// steps, no vertex is further than `radius` / 1000 from its original path. `radius` is the mesh's
// radius.
std::vector<MeshPose> reduce_poses(std::vector<MeshPose> steps, double radius);
// Like reduce_poses(), but for transforms. Embree interpolates the rotations between transforms.
// Returns an empty list if nothing moves.
std::vector<Mat44d> reduce_transforms(std::vector<Mat44d> steps, double radius);

}  // namespace emberline
