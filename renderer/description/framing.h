// What a description takes up in the world, and views of it.
#pragma once

#include "renderer/core/vector.h"

namespace emberline {

struct CameraDescription;
struct SceneDescription;

// Bounds of all placed geometry, world space; empty (min > max) without geometry.
struct WorldBounds {
  Vec3d min = Vec3d(1e300), max = Vec3d(-1e300);
  bool empty() const { return !(min.x <= max.x); }
  Vec3d center() const { return (min + max) * 0.5; }
  double radius() const { return empty() ? 0.0 : (max - min).length() * 0.5; }
};
WorldBounds world_bounds(const SceneDescription& description);

// A camera that frames everything, for files that have none: from the front, a little from the
// right and above, 40 degrees high.
CameraDescription framing_camera(const WorldBounds& bounds, double aspect);

// The radius in metres of a lens of this f-number and of the focal length that gives a film gate 24
// mm high (36 x 24 mm, ISO 1007) the field of view when focused at infinity.
double lens_radius(double f_stop, double fov_y_radians);

// Camera-to-world from a viewpoint. `up` is any direction; along it +Y takes its place, and
// straight up or down the picture's right is +X. Throws UsageError when from and at coincide.
Mat44d look_at_matrix(const Vec3d& from, const Vec3d& at, const Vec3d& up = Vec3d(0.0, 1.0, 0.0));

}  // namespace emberline
