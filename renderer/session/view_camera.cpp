#include "renderer/session/view_camera.h"

#include <algorithm>
#include <cmath>

#include "renderer/scene/camera.h"

namespace emberline {
namespace {

// Limits of the distance, relative to the scene's radius. The nearest distance is close enough to
// count the threads of a cloth; at the farthest distance, the scene is out of sight.
constexpr double kMinDistance = 1e-5, kMaxDistance = 1e5;

// Below this cosine of the elevation, the azimuth is undefined.
constexpr double kPole = 1e-9;

// Returns the direction to the picture's right for a view without roll.
Vec3d horizontal_right(double azimuth) { return {std::cos(azimuth), 0.0, -std::sin(azimuth)}; }

// Sets azimuth, elevation and roll. `back` must be a unit vector. `right` must be perpendicular to
// `back` and must not be mirrored.
void set_angles(const Vec3d& back, const Vec3d& right, ViewCamera& view) {
  const double level = std::hypot(back.x, back.z);
  view.elevation = std::atan2(back.y, level);
  if (level < kPole) {
    view.azimuth = std::atan2(-right.z, right.x);
    view.roll = 0.0;
    return;
  }
  view.azimuth = std::atan2(back.x, back.z);
  const Vec3d level_edge = horizontal_right(view.azimuth);
  view.roll = std::atan2(right.dot(back.cross(level_edge)), right.dot(level_edge));
}

ViewCamera with_distance(ViewCamera view, double distance) {
  view.distance = std::clamp(distance, view.min_distance, view.max_distance);
  return view;
}

// Returns -1 if the view is mirrored, and +1 otherwise.
double handedness(const ViewCamera& view) { return view.mirrored ? -1.0 : 1.0; }

}  // namespace

ViewCamera::Axes ViewCamera::axes() const {
  const double level = std::cos(elevation);
  const Vec3d back(std::sin(azimuth) * level, std::sin(elevation), std::cos(azimuth) * level);
  const Vec3d level_edge = horizontal_right(azimuth);
  const Vec3d right = level_edge * std::cos(roll) + back.cross(level_edge) * std::sin(roll);
  return {right * handedness(*this), back.cross(right), back};
}

double ViewCamera::frame_height() const {
  return 2.0 * (orthographic ? half_height : distance * std::tan(fov_y / 2));
}

double ViewCamera::frame_angle() const {
  return orthographic ? 2.0 * std::atan2(half_height, distance) : fov_y;
}

double ViewCamera::move_scale() const {
  return orthographic ? half_height / std::tan(kDefaultFov / 2) : distance;
}

ViewCamera view_of(const CameraDescription& camera, const Vec3d& center, double radius) {
  const Mat44d& m = camera.to_world;
  ViewCamera view;
  view.min_distance = kMinDistance * radius;
  view.max_distance = kMaxDistance * radius;
  view.mirrored = m.determinant() < 0;
  const Vec3d back = row(m, 2).normalized();
  set_angles(back, row(m, 1).normalized().cross(back).normalized(), view);
  const Vec3d eye = row(m, 3);
  const double center_depth = (eye - center).dot(back);
  view.distance = center_depth > view.min_distance ? center_depth : radius;
  view.pivot = eye - back * view.distance;
  view.orthographic = camera.orthographic;
  if (camera.orthographic) {
    view.fov_y = kDefaultFov;
    view.half_height = camera.y_mag;
  } else {
    view.fov_y = std::clamp(camera.fov_y, kMinFov, kMaxFov);
  }
  return view;
}

CameraEdit edit_of(const ViewCamera& view, const CameraEdit& before) {
  CameraEdit edit = before;
  edit.look_from = view.eye();
  edit.look_at = view.pivot;
  edit.up = view.axes().up;
  edit.mirrored = view.mirrored;
  edit.fov_y_degrees.reset();
  edit.orthographic_height.reset();
  if (view.orthographic) {
    edit.orthographic_height = view.frame_height();
    edit.f_stop.reset();
    edit.focus_distance.reset();
  } else {
    edit.fov_y_degrees = view.fov_y * 180.0 / kPiD;
  }
  return edit;
}

ViewCamera orbit(ViewCamera view, double azimuth, double elevation) {
  view.azimuth = std::remainder(view.azimuth + handedness(view) * azimuth, 2 * kPiD);
  view.elevation = std::clamp(view.elevation + elevation, -kPiD / 2, kPiD / 2);
  return view;
}

ViewCamera turn(ViewCamera view, double yaw, double pitch) {
  const Vec3d eye = view.eye();
  view = orbit(view, yaw, -pitch);
  view.pivot = eye - view.axes().back * view.distance;
  return view;
}

ViewCamera pan(ViewCamera view, double right, double down) {
  const ViewCamera::Axes axes = view.axes();
  view.pivot += (axes.up * down - axes.right * right) * view.frame_height();
  return view;
}

ViewCamera dolly(ViewCamera view, double factor) {
  if (!view.orthographic) return with_distance(view, view.distance * factor);
  view.half_height = std::clamp(view.half_height * factor, view.min_distance, view.max_distance);
  return view;
}

ViewCamera fly(ViewCamera view, double right, double up, double forward) {
  const ViewCamera::Axes axes = view.axes();
  view.pivot += axes.right * right + axes.up * up;
  if (view.orthographic) return dolly(view, std::exp(-forward / view.move_scale()));
  view.pivot -= axes.back * forward;
  return view;
}

ViewCamera to_orthographic(ViewCamera view) {
  view.half_height = 0.5 * view.frame_height();
  view.orthographic = true;
  return view;
}

ViewCamera to_perspective(ViewCamera view, double fov_y) {
  const double height = view.frame_height();
  view.orthographic = false;
  view.fov_y = std::clamp(fov_y, kMinFov, kMaxFov);
  view.distance = 0.5 * height / std::tan(view.fov_y / 2);
  return view;
}

ViewCamera look_towards(ViewCamera view, const Vec3d& point) {
  const Vec3d eye = view.eye();
  const Vec3d away = eye - point;
  const double distance = away.length();
  if (!(distance > 0.0)) return view;
  if (view.orthographic) {
    view.pivot = point;
    view.distance = std::max(away.dot(view.axes().back), view.min_distance);
    return view;
  }
  const double roll = view.roll;
  set_angles(away / distance, horizontal_right(view.azimuth), view);
  view.roll = roll;
  view.pivot = point;
  view.distance = distance;
  return view;
}

ViewCamera frame_all(ViewCamera view, const Vec3d& center, double radius, double aspect) {
  view.pivot = center;
  // Like framing_camera(), fits the sphere between the closer pair of opposite edges, with a margin
  // of 5 %.
  if (view.orthographic) {
    view.half_height = 1.05 * radius / std::min(1.0, aspect);
    return with_distance(view, view.move_scale());  // puts the whole sphere in front of the eye
  }
  const double half = std::atan(std::tan(view.fov_y / 2) * std::min(1.0, aspect));
  return with_distance(view, 1.05 * radius / std::sin(half));
}

}  // namespace emberline
