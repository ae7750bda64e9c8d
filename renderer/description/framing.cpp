#include "renderer/description/framing.h"

#include <algorithm>
#include <cmath>

#include "renderer/core/constants.h"
#include "renderer/core/errors.h"

namespace emberline {

WorldBounds world_bounds(const SceneDescription& description) {
  std::vector<WorldBounds> local(description.meshes.size());
  for (size_t i = 0; i < local.size(); ++i) {
    const MeshDescription& mesh = description.meshes[i];
    if (mesh.reused_bounds) local[i] = *mesh.reused_bounds;
    for (const Vec3f& p : mesh.positions) local[i].extendBy(to_double(p));
    for (const MeshStep& step : mesh.motion) {
      for (const Vec3f& p : step.positions) local[i].extendBy(to_double(p));
    }
  }
  WorldBounds bounds;
  for (const InstanceDescription& instance : description.instances) {
    const WorldBounds& b = local[size_t(instance.mesh)];
    bounds.add(b, instance.to_world);
    for (const Mat44d& step : instance.motion) bounds.add(b, step);
  }
  return bounds;
}

CameraDescription framing_camera(const WorldBounds& bounds, double aspect) {
  CameraDescription camera;
  camera.name = "framing camera";
  camera.fov_y = 40.0 * kPiD / 180.0;
  const double radius = bounds.radius() > 0 ? bounds.radius() : 1.0;
  const double half = std::tan(camera.fov_y / 2) * std::min(1.0, aspect);
  const double distance = 1.05 * radius / std::sin(std::atan(half));
  const Vec3d direction = Vec3d(0.45, 0.35, 1.0).normalized();
  const Vec3d at = bounds.isEmpty() ? Vec3d(0.0) : bounds.center();
  camera.to_world = look_at_matrix(at + direction * distance, at);
  camera.focus_distance = distance;
  return camera;
}

double lens_radius(double f_stop, double fov_y_radians) {
  constexpr double kGateHeight = 0.024;  // metres
  const double focal_length = 0.5 * kGateHeight / std::tan(0.5 * fov_y_radians);
  return 0.5 * focal_length / f_stop;
}

Mat44d look_at_matrix(const Vec3d& from, const Vec3d& at, const Vec3d& upwards) {
  Vec3d back = from - at;
  if (!(back.length2() > 0)) {
    throw UsageError("`look-from` and `look-at` are the same point; move one of them");
  }
  back.normalize();
  Vec3d right = upwards.normalized().cross(back);
  if (right.length2() < 1e-12) right = Vec3d(0, 1, 0).cross(back);
  if (right.length2() < 1e-12) right = Vec3d(1, 0, 0);  // the view is vertical
  right.normalize();
  const Vec3d up = back.cross(right);
  Mat44d m;
  for (int c = 0; c < 3; ++c) {
    m[0][c] = right[c];
    m[1][c] = up[c];
    m[2][c] = back[c];
    m[3][c] = from[c];
  }
  return m;
}

}  // namespace emberline
