#include "renderer/scene/camera.h"

#include <algorithm>
#include <cassert>

#include "renderer/core/constants.h"
#include "renderer/core/errors.h"
#include "renderer/core/warps.h"
#include "renderer/description/scene_description.h"

namespace emberline {
namespace {

Vec3d row(const Mat44d& m, int i) { return {m[i][0], m[i][1], m[i][2]}; }

double largest(const Vec3d& v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

// Whether it can be normalised.
bool is_direction(const Vec3d& v) { return v.length2() > 0 && std::isfinite(v.length2()); }

}  // namespace

Camera::Camera(const CameraDescription& description, int width, int height, const Vec3d& origin,
               double scale, double farthest)
    : orthographic_(description.orthographic) {
  const auto require = [&](bool holds, const char* what) {
    if (!holds) throw InputError("camera '" + description.name + "'", what);
  };
  const Mat44d& m = description.to_world;
  // Scale in the node's transform is not the camera's business (glTF 2.0, section 3.10.1), shear
  // neither: rebuild an orthonormal frame around the viewing axis.
  const Vec3d back = row(m, 2);
  const Vec3d up_hint = row(m, 1);
  require(is_direction(back) && is_direction(up_hint), "its transform has no direction");
  const Vec3d axis = -back.normalized();
  const Vec3d right_raw = axis.cross(up_hint.normalized());
  require(right_raw.length2() > 1e-24, "its transform is flat");
  // A mirrored node shows a mirrored picture.
  const double handed = m.determinant() < 0 ? -1.0 : 1.0;
  const Vec3d up = right_raw.normalized().cross(axis);
  const Vec3d right = right_raw.normalized() * handed;

  double half_height, half_width;
  if (orthographic_) {
    // The vertical extent rules, so that pixels stay square in any frame.
    half_height = description.y_mag * scale;
    half_width = half_height * width / height;
  } else {
    half_height = std::tan(description.fov_y / 2);
    half_width = half_height * width / height;
  }
  const Vec3d position = (row(m, 3) - origin) * scale;
  const double lens_radius = orthographic_ ? 0.0 : description.lens_radius * scale;
  // The sum bounds every coordinate of an origin. Comparisons are false for NaN.
  const double extent = orthographic_ ? half_width + half_height : lens_radius;
  require(largest(position) + extent <= farthest,
          "it is too far from the scene, or too wide, for rays to be traced from there");
  // What a pixel is apart must be more than nothing in float; of directions float holds the
  // squares.
  constexpr double kLeast = 1e-30;
  require(half_height / height >= kLeast && half_width / width >= kLeast,
          "what it shows is too small to be told apart");
  require(orthographic_ || half_width + half_height <= kFarthestOrigin,
          "its field of view is too wide");
  position_ = to_float(position);
  axis_ = to_float(axis);
  corner_ = to_float(up * half_height - right * half_width + (orthographic_ ? Vec3d(0.0) : axis));
  per_x_ = to_float(right * (2 * half_width / width));
  per_y_ = to_float(up * (-2 * half_height / height));
  if (description.lens_radius > 0 && !orthographic_) {
    require(description.focus_distance > 0, "its lens has no distance of focus");
    const double focus = description.focus_distance * scale;
    // Towards a point in focus: float squares that, and of the lens's points keeps more than this.
    require(lens_radius / focus <= kFarthestOrigin && focus > kLeast,
            "its lens is too large for its distance of focus");
    require(largest(position) * kFloatUnit <= 0.25 * focus,
            "it is too far from the scene to be in focus at that distance");
    lens_ = true;
    lens_x_ = to_float(right * lens_radius);
    lens_y_ = to_float(up * lens_radius);
    per_focus_ = float(1.0 / focus);
  }
}

void Camera::rays(std::span<const Vec2f> film, Ray* out) const {
  assert(film.size() <= size_t(kRayBatch));
  // All lanes always, used or not: a loop of fixed length vectorises.
  alignas(64) float x[kRayBatch] = {}, y[kRayBatch] = {};
  for (size_t i = 0; i < film.size(); ++i) {
    x[i] = film[i].x;
    y[i] = film[i].y;
  }
  alignas(64) float dx[kRayBatch], dy[kRayBatch], dz[kRayBatch];
  const float keep = orthographic_ ? 1.0f : 0.0f;
  for (int i = 0; i < kRayBatch; ++i) {
    const Vec3f o = fma(per_y_, y[i], fma(per_x_, x[i], corner_));
    // An orthographic offset may be 0, which must not become NaN.
    const float scale = keep + (1.0f - keep) / std::sqrt(keep + dot(o, o));
    dx[i] = o.x * scale;
    dy[i] = o.y * scale;
    dz[i] = o.z * scale;
  }
  for (size_t i = 0; i < film.size(); ++i) {
    const Vec3f d(dx[i], dy[i], dz[i]);
    out[i] = orthographic_ ? Ray{position_ + d, axis_} : Ray{position_, d};
  }
}

void Camera::rays(std::span<const Vec2f> film, std::span<const Vec2f> lens, Ray* out) const {
  assert(lens_ && lens.size() == film.size() && film.size() <= size_t(kRayBatch));
  Vec2f points[kRayBatch], through[kRayBatch];
  std::ranges::fill(points, Vec2f(0.0f));
  std::ranges::fill(through, Vec2f(0.0f));
  std::ranges::copy(film, points);
  std::ranges::copy(lens, through);
  Ray rays[kRayBatch];
  for (int i = 0; i < kRayBatch; ++i) {  // all lanes always, as above
    const Vec2f disk = square_to_disk(through[i]);
    const Vec3f origin = position_ + fma(lens_y_, disk.y, lens_x_ * disk.x);
    // As rounding left it, so that far from the origin, too, rays meet in the plane of focus.
    const Vec3f shift = origin - position_;
    // The axial part of the pinhole's direction is 1: this is the way to the plane of focus over
    // its distance, which may be infinite.
    const Vec3f pinhole = fma(per_y_, points[i].y, fma(per_x_, points[i].x, corner_));
    const Vec3f direction = fma(shift, -per_focus_, pinhole);
    rays[i] = {origin, direction * (1.0f / std::sqrt(dot(direction, direction)))};
  }
  std::copy_n(rays, film.size(), out);
}

}  // namespace emberline
