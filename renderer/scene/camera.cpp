#include "renderer/scene/camera.h"

#include <Imath/ImathMatrixAlgo.h>

#include <algorithm>
#include <cassert>

#include "renderer/core/branch_free.h"
#include "renderer/core/constants.h"
#include "renderer/core/errors.h"
#include "renderer/core/shortened.h"
#include "renderer/core/warps.h"
#include "renderer/description/scene_description.h"

namespace emberline {
namespace {

Imath::Quatd rotation_of(const auto& pose) {
  Mat44d m;
  for (int c = 0; c < 3; ++c) {
    m[0][c] = pose.right[c];
    m[1][c] = pose.up[c];
    m[2][c] = -pose.axis[c];
  }
  return Imath::extractQuat(m);
}

float pixels_per_frame(double pixels, double frames) {
  constexpr double kMaxVelocity = 65504.0;  // largest half float
  const double velocity = pixels / frames;
  return std::isfinite(velocity) ? float(std::clamp(velocity, -kMaxVelocity, kMaxVelocity)) : 0.0f;
}

bool is_direction(const Vec3d& v) { return v.length2() > 0 && std::isfinite(v.length2()); }

}  // namespace

Camera::Camera(const CameraDescription& description, int width, int height, const Vec3d& origin,
               double scale, double max_origin) {
  const auto require = [&](bool condition, const char* what) {
    if (!condition) throw InputError("camera '" + shortened(description.name) + "'", what);
  };
  Shape& s = shape_;
  s.panorama = description.panorama;
  s.orthographic = description.orthographic && !s.panorama;
  s.width = width;
  s.height = height;
  s.turns_per_pixel = {float(1.0 / width), float(0.5 / height)};
  // The description gives the vertical extent, so that pixels stay square in any frame.
  s.half_height = half_height_of(s.orthographic ? description.y_mag : description.fov_y, scale);
  s.half_width = s.half_height * width / height;
  s.per_column = 2 * s.half_width / width;
  s.per_row = -2 * s.half_height / height;
  // A mirrored node mirrors the image.
  s.handed = description.to_world.determinant() < 0 ? -1.0 : 1.0;
  const bool projects = !s.orthographic && !s.panorama;
  s.lens_radius = projects ? description.lens_radius * scale : 0.0;
  if (!s.panorama) zoom_ = description.zoom;
  scale_ = scale;
  double smallest = 1.0;
  for (size_t i = 0; zoom_ && i < zoom_->values.size(); ++i) {
    const double size = half_height_of(zoom_->values[i], scale) / s.half_height;
    smallest = std::min(smallest, size);
    max_size_ = std::max(max_size_, size);
  }
  if (zoom_) end_size_ = half_height_of(zoom_->at(1.0f), scale) / s.half_height;
  const Pose pose = pose_of(description.to_world, description.name, origin, scale, max_origin);
  // Float must be able to distinguish pixels and to hold the squares of directions.
  constexpr double kMinExtent = 1e-30;
  require(smallest * s.half_height / height >= kMinExtent &&
              smallest * s.half_width / width >= kMinExtent,
          "its field of view is too small");
  require(s.orthographic || max_size_ * (s.half_width + s.half_height) <= kMaxOrigin,
          "its field of view is too wide");
  if (projects && description.lens_radius > 0) {
    require(description.focus_distance > 0, "its lens has no focus distance");
    const double focus = description.focus_distance * scale;
    // Float must hold the squared direction to a point in focus, and 1 / focus.
    require(s.lens_radius / focus <= kMaxOrigin && focus > kMinExtent,
            "its lens is too large for its focus distance");
    require(max_abs_component(pose.position) * kFloatUnit <= 0.25 * focus,
            "it is too far from the scene for its focus distance");
    s.lens = true;
    s.inverse_focus_distance = float(1.0 / focus);
  }
  view_ = view_from(pose);
  const auto place = [&](const Mat44d& m) {
    return pose_of(m, description.name, origin, scale, max_origin);
  };
  pose_ = end_pose_ = pose;
  if (description.next_frame) end_pose_ = place(*description.next_frame);
  if (description.motion.empty()) return;
  end_pose_ = place(description.motion.back());
  const auto add = [&](const Pose& p) { steps_.push_back({p.position, rotation_of(p)}); };
  add(pose);
  for (const Mat44d& step : description.motion) add(place(step));
}

Camera::Pose Camera::pose_of(const Mat44d& m, const std::string& name, const Vec3d& origin,
                             double scale, double max_origin) const {
  const auto require = [&](bool condition, const char* what) {
    if (!condition) throw InputError("camera '" + shortened(name) + "'", what);
  };
  // The camera ignores scale (glTF 2.0, section 3.10.1) and shear in the node's transform. Rebuild
  // an orthonormal frame around the viewing axis.
  const Vec3d back = row(m, 2);
  const Vec3d up_hint = row(m, 1);
  require(is_direction(back) && is_direction(up_hint),
          "its transform has an axis of zero or infinite length");
  const Vec3d axis = -back.normalized();
  const Vec3d right_raw = axis.cross(up_hint.normalized());
  require(right_raw.length2() > 1e-24, "its viewing axis and its up axis are parallel");
  const Vec3d right = right_raw.normalized();
  const Vec3d position = (row(m, 3) - origin) * scale;
  // The sum bounds every coordinate of a ray origin. The comparison is false for NaN.
  const double extent = shape_.orthographic ? max_size_ * (shape_.half_width + shape_.half_height)
                                            : shape_.lens_radius;
  require(max_abs_component(position) + extent <= max_origin,
          "it is too far from the scene or too wide to trace rays from it");
  return {position, right, right.cross(axis), axis};
}

Camera::View Camera::view_from(const Pose& pose, double size) const {
  const Shape& s = shape_;
  const Vec3d right = pose.right * s.handed;
  View view;
  view.position = to_float(pose.position);
  view.axis = to_float(pose.axis);
  view.corner = to_float((pose.up * s.half_height - right * s.half_width) * size +
                         (s.orthographic ? Vec3d(0.0) : pose.axis));
  view.per_x = to_float(right * (s.per_column * size));
  view.per_y = to_float(pose.up * (s.per_row * size));
  view.lens_x = to_float(right * s.lens_radius);
  view.lens_y = to_float(pose.up * s.lens_radius);
  return view;
}

double Camera::half_height_of(double size, double scale) const {
  return shape_.orthographic ? size * scale : std::tan(size / 2);
}

Camera::View Camera::view_at(float time) const {
  if (!zoom_) return view_from(pose_at(time));
  return view_from(pose_at(time), half_height_of(zoom_->at(time), scale_) / shape_.half_height);
}

// Interpolates linearly in position and spherically in rotation between two steps.
Camera::Pose Camera::pose_at(float time) const {
  if (steps_.empty()) return pose_;
  const auto segments = double(steps_.size() - 1);
  const double scaled = double(time) * segments;
  const auto before = size_t(std::clamp(scaled, 0.0, segments - 1));
  const double fraction = scaled - double(before);
  const Step &a = steps_[before], &b = steps_[before + 1];
  const Imath::M33d rows = Imath::slerpShortestArc(a.rotation, b.rotation, fraction).toMatrix33();
  const auto row = [&](int i) { return Vec3d(rows[i][0], rows[i][1], rows[i][2]); };
  return {a.position + (b.position - a.position) * fraction, row(0), row(1), -row(2)};
}

Ray Camera::ray(const Vec2f& film, const Vec2f& lens, float time) const {
  const View view = moves() ? view_at(time) : view_;
  Ray ray;
  if (shape_.lens) {
    generate_rays(view, {&film, 1}, {&lens, 1}, &ray);
  } else {
    generate_rays(view, {&film, 1}, &ray);
  }
  ray.time = time;
  return ray;
}

Imath::Box3f Camera::origin_bounds() const {
  const Shape& s = shape_;
  const auto margin = Vec3f(float(
      s.orthographic ? 2 * max_size_ * std::hypot(s.half_width, s.half_height) : s.lens_radius));
  Imath::Box3f box;
  const auto add = [&](const Vec3d& position) {
    box.extendBy(to_float(position) - margin);
    box.extendBy(to_float(position) + margin);
  };
  add(pose_.position);
  for (const Step& step : steps_) add(step.position);
  return box;
}

// Returns the components to the right, up and ahead.
Vec3d Camera::to_view_space(const Pose& pose, const Vec3d& displacement) const {
  return {dot(displacement, pose.right) * shape_.handed, dot(displacement, pose.up),
          dot(displacement, pose.axis)};
}

// Inverts the projection of view_from().
Vec3d Camera::project_to_film(const Vec3d& point) const {
  const Vec3d p = to_view_space(pose_, point - pose_.position);
  return {(p.x + shape_.half_width * p.z) / shape_.per_column,
          (p.y - shape_.half_height * p.z) / shape_.per_row, p.z};
}

Camera::WorldMatrices Camera::world_matrices(const Vec3d& origin) const {
  const std::array<Vec3d, 3> axes = {pose_.right * shape_.handed, pose_.up, pose_.axis};
  const Vec3d position = pose_.position / scale_ + origin;
  Mat44d to_camera;
  for (int a = 0; a < 3; ++a) {
    for (int c = 0; c < 3; ++c) to_camera[c][a] = axes[size_t(a)][c];
    to_camera[3][a] = -dot(position, axes[size_t(a)]);
  }
  const double unit = shape_.orthographic ? scale_ : 1.0;
  const double x = unit / (2 * shape_.half_width), y = -unit / (2 * shape_.half_height);
  const Mat44d film = shape_.orthographic
                          ? Mat44d(x, 0, 0, 0, 0, y, 0, 0, 0, 0, 1, 0, 0.5, 0.5, 0, 1)
                          : Mat44d(x, 0, 0, 0, 0, y, 0, 0, 0.5, 0.5, 0, 1, 0, 0, 1, 0);
  return {to_camera, to_camera * film};
}

Vec2f Camera::velocity(const Vec3d& from, const Vec3d& to, double frames) const {
  if (shape_.panorama)
    return panorama_velocity(from - pose_.position, to - end_pose_.position, frames);
  return film_velocity(to_view_space(pose_, from - pose_.position),
                       to_view_space(end_pose_, to - end_pose_.position), frames);
}

Vec2f Camera::velocity(const Vec3d& direction, double frames) const {
  if (shape_.orthographic || shape_.panorama) return Vec2f(0.0f);
  return film_velocity(to_view_space(pose_, direction), to_view_space(end_pose_, direction),
                       frames);
}

// Returns the film velocity of a point that moves from `from` to `to`. Each position is in the view
// space at its own time.
Vec2f Camera::film_velocity(const Vec3d& from, const Vec3d& to, double frames) const {
  // We chose this ratio. A point that moves parallel to the axis to this fraction of its depth
  // appears a hundred times as far from the axis.
  constexpr double kMinDepthRatio = 0.01;
  const double min_depth = kMinDepthRatio * std::max(from.z, to.z);
  const auto project_to_film = [&](const Vec3d& p, const Vec3d& other) {
    if (shape_.orthographic) return p;
    if (p.z >= min_depth) return p / p.z;
    return (other + (p - other) * ((other.z - min_depth) / (other.z - p.z))) / min_depth;
  };
  if (!shape_.orthographic && !(min_depth > 0.0)) return Vec2f(0.0f);
  const Vec3d displacement = project_to_film(to, from) / end_size_ - project_to_film(from, to);
  return {pixels_per_frame(displacement.x / shape_.per_column, frames),
          pixels_per_frame(displacement.y / -shape_.per_row, frames)};
}

// Returns the film velocity of a point that moves from `from` to `to`. Each position is relative to
// the camera at its own time.
Vec2f Camera::panorama_velocity(const Vec3d& from, const Vec3d& to, double frames) const {
  const auto longitude = [](const Vec3d& v) { return std::atan2(v.z, v.x) / (2 * kPiD); };
  const auto latitude = [](const Vec3d& v) { return std::atan2(v.y, std::hypot(v.x, v.z)) / kPiD; };
  double longitude_change = longitude(to) - longitude(from);
  longitude_change -= std::nearbyint(longitude_change);
  return {pixels_per_frame(longitude_change * shape_.width, frames),
          pixels_per_frame((latitude(to) - latitude(from)) * shape_.height, frames)};
}

void Camera::generate_panorama_rays(const View& view, std::span<const Vec2f> film, Ray* out) const {
  for (size_t i = 0; i < film.size(); ++i) {
    // The left edge shows -X. Filter samples beyond a pole continue on its other side.
    const float turns = 0.5f + film[i].x * shape_.turns_per_pixel.x;
    const float polar = film[i].y * shape_.turns_per_pixel.y;
    float sin_phi, cos_phi, sin_theta, cos_theta;
    sincos_turns(turns - std::floor(turns), &sin_phi, &cos_phi);
    sincos_turns(polar - std::floor(polar), &sin_theta, &cos_theta);
    out[i] = {view.position, Vec3f(sin_theta * cos_phi, cos_theta, sin_theta * sin_phi)};
  }
}

void Camera::generate_rays(const View& view, std::span<const Vec2f> film, Ray* out) const {
  assert(film.size() <= size_t(kRayBatch));
  if (shape_.panorama) [[unlikely]] {
    generate_panorama_rays(view, film, out);
    return;
  }
  // Computes all lanes, even unused ones, because a loop of fixed length vectorises.
  alignas(64) float x[kRayBatch] = {}, y[kRayBatch] = {};
  for (size_t i = 0; i < film.size(); ++i) {
    x[i] = film[i].x;
    y[i] = film[i].y;
  }
  alignas(64) float dx[kRayBatch], dy[kRayBatch], dz[kRayBatch];
  const float parallel_weight = shape_.orthographic ? 1.0f : 0.0f;
  for (int i = 0; i < kRayBatch; ++i) {
    const Vec3f o = fma(view.per_y, y[i], fma(view.per_x, x[i], view.corner));
    // The added weight avoids 0 / 0, since an orthographic offset may be 0.
    const float scale =
        parallel_weight + (1.0f - parallel_weight) / std::sqrt(parallel_weight + dot(o, o));
    dx[i] = o.x * scale;
    dy[i] = o.y * scale;
    dz[i] = o.z * scale;
  }
  for (size_t i = 0; i < film.size(); ++i) {
    const Vec3f d(dx[i], dy[i], dz[i]);
    out[i] = shape_.orthographic ? Ray{view.position + d, view.axis} : Ray{view.position, d};
  }
}

void Camera::generate_rays(const View& view, std::span<const Vec2f> film,
                           std::span<const Vec2f> lens, Ray* out) const {
  assert(shape_.lens && lens.size() == film.size() && film.size() <= size_t(kRayBatch));
  Vec2f points[kRayBatch], lens_points[kRayBatch];
  std::ranges::fill(points, Vec2f(0.0f));
  std::ranges::fill(lens_points, Vec2f(0.0f));
  std::ranges::copy(film, points);
  std::ranges::copy(lens, lens_points);
  Ray rays[kRayBatch];
  for (int i = 0; i < kRayBatch; ++i) {  // all lanes, as above
    const Vec2f disk = square_to_disk(lens_points[i]);
    const Vec3f origin = view.position + fma(view.lens_y, disk.y, view.lens_x * disk.x);
    // Use the rounded shift, so that rays meet in the plane of focus even far from the origin.
    const Vec3f shift = origin - view.position;
    // The pinhole direction's axial component is 1, so `direction` is the vector to the plane of
    // focus divided by the focus distance, which may be infinite.
    const Vec3f pinhole = fma(view.per_y, points[i].y, fma(view.per_x, points[i].x, view.corner));
    const Vec3f direction = fma(shift, -shape_.inverse_focus_distance, pinhole);
    rays[i] = {origin, direction * (1.0f / std::sqrt(dot(direction, direction)))};
  }
  std::copy_n(rays, film.size(), out);
}

}  // namespace emberline
