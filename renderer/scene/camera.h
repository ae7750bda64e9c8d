// Where rays start: perspective and orthographic pinholes, and a thin lens.
//
// The lens is that of R. Cook, T. Porter, L. Carpenter, "Distributed Ray Tracing" (SIGGRAPH 1984):
// all light that leaves a point of the plane in focus towards the lens meets in one point of the
// film. Terms as in C. Kolb, D. Mitchell, P. Hanrahan, "A Realistic Camera Model for Computer
// Graphics" (SIGGRAPH 1995), section 3. The frame is that of the pinhole in the lens's middle:
// it does not grow or shrink with the focus, and there is no fall-off towards the corners.
#pragma once

#include <span>

#include "renderer/core/ray.h"
#include "renderer/core/vector.h"

namespace emberline {

struct CameraDescription;

// Maps points of the frame to rays in the scene's internal space. Immutable; thread-safe.
class Camera {
 public:
  Camera() = default;
  // width x height: the frame in pixels. `origin` and `scale` are the scene's rebasing: internal =
  // (world - origin) * scale; `farthest` is where its rays may start (Scene::farthest). Throws
  // InputError for a camera without a direction, with a lens that is focused nowhere, and for one
  // whose rays float cannot hold.
  Camera(const CameraDescription& description, int width, int height, const Vec3d& origin,
         double scale, double farthest = kFarthestOrigin);

  // film: continuous pixel coordinates, (0, 0) the frame's top-left corner, y downwards. Up to
  // kRayBatch at once, so that the arithmetic vectorises; a ray does not depend on its neighbours.
  void rays(std::span<const Vec2f> film, Ray* out) const;
  // Whether there is a lens, and rays are asked for by its points.
  bool has_lens() const { return lens_; }
  // The same through points of the lens: `lens` in the unit square, uniform, one per point of film.
  void rays(std::span<const Vec2f> film, std::span<const Vec2f> lens, Ray* out) const;
  // Through the lens's middle.
  Ray ray(const Vec2f& film) const {
    Ray result;
    rays({&film, 1}, &result);
    return result;
  }

  // Distance along the viewing axis of an internal-space point, from the lens's plane.
  float axial_depth(const Vec3f& point) const { return dot(point - position_, axis_); }

 private:
  bool orthographic_ = false;
  Vec3f position_ = Vec3f(0.0f);
  Vec3f axis_ = Vec3f(0.0f, 0.0f, -1.0f);
  // Direction (perspective) or offset (orthographic) of film (0, 0), and per pixel right and down.
  Vec3f corner_ = Vec3f(0.0f);
  Vec3f per_x_ = Vec3f(0.0f), per_y_ = Vec3f(0.0f);
  bool lens_ = false;
  Vec3f lens_x_ = Vec3f(0.0f), lens_y_ = Vec3f(0.0f);  // the lens's radius to the right and up
  float per_focus_ = 0.0f;  // 1 / distance of the plane in focus; 0: infinity
};

}  // namespace emberline
