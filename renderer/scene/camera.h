// Where rays start: perspective and orthographic pinholes.
#pragma once

#include <span>

#include "renderer/core/features.h"
#include "renderer/core/ray.h"
#include "renderer/core/vector.h"

namespace emberline {

struct CameraDescription;

// Maps points of the frame to rays in the scene's internal space. Immutable; thread-safe.
class Camera {
 public:
  Camera() = default;
  // width x height: the frame in pixels. `origin` and `scale` are the scene's rebasing: internal =
  // (world - origin) * scale. Throws InputError for a camera without a direction.
  Camera(const CameraDescription& description, int width, int height, const Vec3d& origin,
         double scale);

  // film: continuous pixel coordinates, (0, 0) the frame's top-left corner, y downwards. Up to
  // kRayBatch at once, so that the arithmetic vectorises; a ray does not depend on its neighbours.
  void rays(std::span<const Vec2f> film, Ray* out) const;
  Ray ray(const Vec2f& film) const {
    Ray result;
    rays({&film, 1}, &result);
    return result;
  }

  // Distance along the viewing axis of an internal-space point.
  float axial_depth(const Vec3f& point) const { return dot(point - position_, axis_); }

 private:
  features::Flag<features::kOrthographic> orthographic_ = false;
  Vec3f position_ = Vec3f(0.0f);
  Vec3f axis_ = Vec3f(0.0f, 0.0f, -1.0f);
  // Direction (perspective) or offset (orthographic) of film (0, 0), and per pixel right and down.
  Vec3f corner_ = Vec3f(0.0f);
  Vec3f per_x_ = Vec3f(0.0f), per_y_ = Vec3f(0.0f);
};

// Camera-to-world from a viewpoint. `up` is any direction; along it +Y takes its place, and
// straight up or down the picture's right is +X. Throws UsageError when from and at coincide.
Mat44d look_at_matrix(const Vec3d& from, const Vec3d& at, const Vec3d& up = Vec3d(0.0, 1.0, 0.0));

}  // namespace emberline
