// Where a file's nodes are while the shutter is open: at even times, as many as the motion asks
// for; of an instant whose velocity is wanted, then and later.
#pragma once

#include <vector>

#include "io/gltf/animation/animation.h"
#include "io/gltf/geometry/mesh.h"

namespace emberline {

class GltfShutter {
 public:
  // Of an animation. Throws InputError when memory does not allow it.
  GltfShutter(const GltfDocument& document, const GltfAnimation& animation);

  // Of every node, as the shutter opens.
  const std::vector<Mat44d>& world() const { return world_; }
  const GltfPose& pose(size_t step = 0) const { return poses_[step]; }

  // What a mesh's accessors say of its vertices, before they are posed; empty where they say
  // nothing. Of an animation, not at rest.
  const WorldBounds& bounds(size_t mesh) const { return bounds_[mesh]; }
  // The same as a ball around the mesh's origin; infinite where they say nothing.
  double radius(size_t mesh) const;

  // Poses, the first included; 1: nothing moves.
  size_t steps() const { return poses_.size(); }
  // Whether the second pose, if there is one, is GltfAnimation::later.
  bool is_instant() const { return animation_.later.has_value(); }
  bool moves(size_t node) const { return !moving_.empty() && moving_[node] != kAtRest; }
  // Of a node that moves.
  const Mat44d& world(size_t node, size_t step) const { return motion_[step][moving_[node]]; }

 private:
  static constexpr uint32_t kAtRest = ~0u;
  void find_moving_nodes();
  void pose_at_steps(size_t segments);
  bool fine_enough() const;
  bool is_mirrored_midway(size_t i) const;
  double radius_of(size_t i) const;  // of a node of order_

  const GltfDocument& document_;
  const GltfAnimation& animation_;
  const double open_, close_;
  std::vector<WorldBounds> bounds_;  // per mesh
  std::vector<GltfPose> poses_;
  std::vector<Mat44d> world_;
  std::vector<uint32_t> moving_;             // per node: its place in motion_
  std::vector<size_t> order_;                // of those that move, parents first
  std::vector<std::vector<Mat44d>> motion_;  // per step, of the nodes of order_
  MemoryReservation memory_;
};

// How thick a flat thing is, as a share of its size in the plane: that keeps its front before its
// back. Chosen by us; a picture shows nothing of it.
inline constexpr double kThickness = 4e-6;

// A thing that is flat at some step is that thick then; `center` is its middle. One that vanishes
// at some step, its size being none, is very small then: transforms without inverse become those of
// the nearest step that has one, at a ten-thousandth of its size. Empty if none has.
std::vector<Mat44d> with_inverses(std::vector<Mat44d> steps, const Vec3d& center);

// Fewer steps, evenly spaced, that put every vertex of a mesh of that radius to within a thousandth
// of it where all of them would; vertices go straight between them.
std::vector<MeshPose> thinned_poses(std::vector<MeshPose> steps, double radius);
// The same of transforms, between which Embree turns; `radius`: of the mesh. Empty: it does not
// move at all.
std::vector<Mat44d> thinned_transforms(std::vector<Mat44d> steps, double radius);

}  // namespace emberline
