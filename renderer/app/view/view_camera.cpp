#include "renderer/app/view/view_camera.h"

#include <algorithm>
#include <cmath>

#include "renderer/core/constants.h"
#include "renderer/scene/camera.h"

namespace emberline {
namespace {

// Of what an orthographic camera becomes.
constexpr double kOrthographicFov = kPiD / 6;

// In radii of the scene: near enough to count the threads of a cloth, far enough to lose it.
constexpr double kLeastDistance = 1e-5, kMostDistance = 1e5;

// A cosine of the elevation below this says nothing of the azimuth.
constexpr double kPole = 1e-9;

Vec3d row(const Mat44d& m, int i) { return {m[i][0], m[i][1], m[i][2]}; }

// The picture's right edge without roll.
Vec3d level_right(double azimuth) { return {std::cos(azimuth), 0.0, -std::sin(azimuth)}; }

// `back` is a unit vector, `right` any direction across it.
void set_angles(const Vec3d& back, const Vec3d& right, ViewCamera& view) {
  const double level = std::hypot(back.x, back.z);
  view.elevation = std::atan2(back.y, level);
  if (level < kPole) {
    view.azimuth = std::atan2(-right.z, right.x);
    view.roll = 0.0;
    return;
  }
  view.azimuth = std::atan2(back.x, back.z);
  const Vec3d level_edge = level_right(view.azimuth);
  view.roll = std::atan2(right.dot(back.cross(level_edge)), right.dot(level_edge));
}

ViewCamera with_distance(ViewCamera view, double distance) {
  view.distance = std::clamp(distance, view.least_distance, view.most_distance);
  return view;
}

// The same eye and axes, with the pivot so far away.
ViewCamera with_eye_kept(ViewCamera view, double distance) {
  const Vec3d eye = view.eye();
  view = with_distance(view, distance);
  view.pivot = eye - view.axes().back * view.distance;
  return view;
}

double frame_height(const ViewCamera& view) {
  return 2.0 * view.distance * std::tan(view.fov_y / 2);
}

}  // namespace

ViewCamera::Axes ViewCamera::axes() const {
  const double level = std::cos(elevation);
  const Vec3d back(std::sin(azimuth) * level, std::sin(elevation), std::cos(azimuth) * level);
  const Vec3d level_edge = level_right(azimuth);
  const Vec3d right = level_edge * std::cos(roll) + back.cross(level_edge) * std::sin(roll);
  return {right, back.cross(right), back};
}

ViewCamera view_of(const CameraDescription& camera, const Vec3d& center, double radius) {
  const Mat44d& m = camera.to_world;
  ViewCamera view;
  view.least_distance = kLeastDistance * radius;
  view.most_distance = kMostDistance * radius;
  const Vec3d back = row(m, 2).normalized();
  Vec3d right = row(m, 1).normalized().cross(back).normalized();
  set_angles(back, right, view);
  const Vec3d eye = row(m, 3);
  const double abreast = (eye - center).dot(back);
  if (!camera.orthographic) {
    view.fov_y = std::clamp(camera.fov_y, kLeastFov, kMostFov);
    view.distance = abreast > view.least_distance ? abreast : radius;
    view.pivot = eye - back * view.distance;
    return view;
  }
  view.fov_y = kOrthographicFov;
  view.pivot = eye - back * abreast;
  view.distance = camera.y_mag / std::tan(view.fov_y / 2);
  return view;
}

CameraEdit edit_of(const ViewCamera& view, const CameraEdit& before) {
  CameraEdit edit = before;
  edit.look_from = view.eye();
  edit.look_at = view.pivot;
  edit.up = view.axes().up;
  edit.fov_y_degrees = view.fov_y * 180.0 / kPiD;
  return edit;
}

ViewCamera orbit(ViewCamera view, double azimuth, double elevation) {
  view.azimuth = std::remainder(view.azimuth + azimuth, 2 * kPiD);
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
  view.pivot += (axes.up * down - axes.right * right) * frame_height(view);
  return view;
}

ViewCamera dolly(ViewCamera view, double factor) {
  return with_distance(view, view.distance * factor);
}

ViewCamera fly(ViewCamera view, double right, double up, double forward) {
  const ViewCamera::Axes axes = view.axes();
  view.pivot += axes.right * right + axes.up * up - axes.back * forward;
  return view;
}

ViewCamera with_fov(ViewCamera view, double fov_y) {
  view.fov_y = std::clamp(fov_y, kLeastFov, kMostFov);
  return view;
}

ViewCamera look_towards(ViewCamera view, const Vec3d& point) {
  const Vec3d eye = view.eye();
  const Vec3d away = eye - point;
  const double distance = away.length();
  if (!(distance > 0.0)) return view;
  const double roll = view.roll;
  set_angles(away / distance, view.axes().right, view);
  view.roll = roll;
  view.pivot = point;
  view.distance = distance;
  return view;
}

ViewCamera with_pivot_at(ViewCamera view, const Vec3d& point) {
  return with_eye_kept(view, (view.eye() - point).dot(view.axes().back));
}

ViewCamera frame_all(ViewCamera view, const Vec3d& center, double radius, double aspect) {
  view.pivot = center;
  // As framing_camera does: the sphere touches the frame's nearer edges, and 5 % are left.
  const double half = std::atan(std::tan(view.fov_y / 2) * std::min(1.0, aspect));
  return with_distance(view, 1.05 * radius / std::sin(half));
}

}  // namespace emberline
