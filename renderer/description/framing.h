// World bounds of a description, and views of it.
#pragma once

#include "renderer/core/vector.h"
#include "renderer/description/scene_description.h"

namespace emberline {

// Bounds of all placed geometry at all its time steps.
WorldBounds world_bounds(const SceneDescription& description);
// Bounds for a view of the whole scene, the same at any time of an animation.
inline WorldBounds framed_bounds(const SceneDescription& description) {
  return description.rest_bounds ? *description.rest_bounds : world_bounds(description);
}

// A camera that frames everything, for files without one: from the front, slightly from the right
// and above, 40 degrees high.
CameraDescription framing_camera(const WorldBounds& bounds, double aspect);

// The radius in metres of a lens with this f-number. Its focal length gives a 24 mm high film gate
// (36 x 24 mm, ISO 1007) the field of view when focused at infinity.
double lens_radius(double f_stop, double fov_y_radians);

// Camera-to-world from a viewpoint. `up` is any direction; if it is parallel to the view, +Y is
// used, and for a vertical view the image's right is +X. Throws UsageError if from and at coincide.
Mat44d look_at_matrix(const Vec3d& from, const Vec3d& at, const Vec3d& up = Vec3d(0.0, 1.0, 0.0));

}  // namespace emberline
