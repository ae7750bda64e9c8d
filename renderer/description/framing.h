// World bounds of a description, and cameras that view it.
#pragma once

#include "renderer/core/vector.h"
#include "renderer/description/scene_description.h"

namespace emberline {

// Returns the bounds of all instances, including their positions in `motion`.
WorldBounds world_bounds(const SceneDescription& description);
// Returns the bounds that a view of the whole scene frames. They are the same at all times of an
// animation.
inline WorldBounds framed_bounds(const SceneDescription& description) {
  return description.rest_bounds ? *description.rest_bounds : world_bounds(description);
}

// Returns a camera that frames everything, for files without cameras. It looks from the front,
// slightly from the right and above, with a vertical field of view of 40 degrees.
CameraDescription framing_camera(const WorldBounds& bounds, double aspect);

// Returns the radius in metres of a lens with this f-number. The focal length is that of a camera
// with this vertical field of view whose film gate is 24 mm high (36 x 24 mm, ISO 1007), focused at
// infinity.
double lens_radius(double f_stop, double fov_y_radians);

// Returns the camera-to-world matrix of a view from `from` towards `at`. If `up` is parallel to the
// view, +Y replaces it. If +Y is parallel to the view, too, the image's right is +X. Throws
// UsageError if `from` and `at` coincide.
Mat44d look_at_matrix(const Vec3d& from, const Vec3d& at, const Vec3d& up = Vec3d(0.0, 1.0, 0.0));

}  // namespace emberline
