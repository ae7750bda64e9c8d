// Where rays start: perspective and orthographic pinholes, a thin lens, and a panorama: all that is
// seen from one place, on a latitude-longitude map in the world's axes, as EnvironmentDescription
// has it, whichever way the camera looks.
//
// The lens is that of R. Cook, T. Porter, L. Carpenter, "Distributed Ray Tracing" (SIGGRAPH 1984):
// all light that leaves a point of the plane in focus towards the lens meets in one point of the
// film. Terms as in C. Kolb, D. Mitchell, P. Hanrahan, "A Realistic Camera Model for Computer
// Graphics" (SIGGRAPH 1995), section 3. The frame is that of the pinhole in the lens's middle:
// it does not grow or shrink with the focus, and there is no fall-off towards the corners.
#pragma once

#include <Imath/ImathBox.h>
#include <Imath/ImathQuat.h>

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "renderer/core/ray.h"
#include "renderer/core/time_curve.h"
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
  void rays(std::span<const Vec2f> film, Ray* out) const { cast(view_, film, out); }
  // Whether there is a lens, and rays are asked for by its points.
  bool has_lens() const { return shape_.lens; }
  // The same through points of the lens: `lens` in the unit square, uniform, one per point of film.
  void rays(std::span<const Vec2f> film, std::span<const Vec2f> lens, Ray* out) const {
    cast(view_, film, lens, out);
  }
  // Through the lens's middle.
  Ray ray(const Vec2f& film) const {
    Ray result;
    rays({&film, 1}, &result);
    return result;
  }

  // Whether it moves or zooms while the shutter is open. The rays above are those at its opening.
  bool moves() const { return zoom_ || !steps_.empty(); }
  // One ray at a time in [0, 1]; `lens` as above, not looked at without one.
  Ray ray(const Vec2f& film, const Vec2f& lens, float time) const;

  // Where its rays may start, internal, while the shutter is open: of film that is at most twice as
  // wide and high as the frame.
  Imath::Box3f origins() const;

  // Perspective through a pinhole, as it is for as long as the shutter is open. Of such a one
  // alone:
  bool is_still_pinhole() const {
    return !shape_.orthographic && !shape_.panorama && !shape_.lens && !moves();
  }
  bool is_panorama() const { return shape_.panorama; }
  const Vec3d& position() const { return pose_.position; }
  // Size of a pixel at distance 1.
  Imath::V2d pixel_size() const { return {shape_.per_column, -shape_.per_row}; }
  // Continuous pixel coordinates of an internal-space point, times its depth, which is the third.
  Vec3d on_film(const Vec3d& point) const;

  // From the world, whose `origin` is the scene's, as OpenEXR's header has them, at the shutter's
  // opening: to the right, up and ahead; and, after a division by w, to the frame, (0, 0) its upper
  // left and (1, 1) its lower right corner (z is 1 / depth; of an orthographic one the depth). Not
  // of a panorama, which no matrix makes.
  struct WorldMatrices {
    Mat44d to_camera, to_ndc;
  };
  WorldMatrices world_matrices(const Vec3d& origin) const;

  // Distance along the viewing axis of an internal-space point, from the lens's plane; of a
  // panorama from its place.
  float axial_depth(const Vec3f& point, float time) const {
    if (moves()) [[unlikely]]
      return axial_depth(view_at(time), point);
    return axial_depth(view_, point);
  }

  // On the film, in pixels a frame to the right and up: of a point that is at `from` as the shutter
  // opens and at `to` as it closes, `frames` later; of an instant, then and a frame later
  // (CameraDescription::later). Seen through the lens's middle. What comes nearer to the camera's
  // plane than a hundredth of its depth, or passes it, goes as far as there; half floats hold it.
  // In a panorama it goes the shorter way round.
  Vec2f velocity(const Vec3d& from, const Vec3d& to, double frames) const;
  // The same of what is infinitely far away in a direction: the camera's turning.
  Vec2f velocity(const Vec3d& direction, double frames) const;

 private:
  // Where it stands and which way it looks; a right-handed frame, internal.
  struct Pose {
    Vec3d position, right, up, axis;
  };
  struct Step {
    Vec3d position;
    Imath::Quatd rotation;
  };
  // What does not move: half the picture's size at the shutter's opening, of a perspective one at
  // distance 1; the way from one pixel to the next; -1 for a mirrored picture, else 1; the lens's
  // radius.
  struct Shape {
    bool orthographic = false, panorama = false;
    double width = 1.0, height = 1.0;  // of a panorama, in pixels
    Vec2f turns_per_pixel = Vec2f(0.0f);
    double half_width = 1.0, half_height = 1.0, per_column = 1.0, per_row = -1.0, handed = 1.0;
    bool lens = false;
    double lens_radius = 0.0;
    float per_focus = 0.0f;  // 1 / distance of the plane in focus; 0: infinity
  };
  // Both at one time.
  struct View {
    Vec3f position = Vec3f(0.0f);
    Vec3f axis = Vec3f(0.0f, 0.0f, -1.0f);
    // Direction (perspective) or offset (orthographic) of film (0, 0), and per pixel right and
    // down.
    Vec3f corner = Vec3f(0.0f);
    Vec3f per_x = Vec3f(0.0f), per_y = Vec3f(0.0f);
    Vec3f lens_x = Vec3f(0.0f), lens_y = Vec3f(0.0f);  // the lens's radius to the right and up
  };

  // Half the picture's height, of a field of view or a magnification.
  double half_height_of(double size, double scale) const;
  Pose pose_of(const Mat44d& to_world, const std::string& name, const Vec3d& origin, double scale,
               double farthest) const;
  Pose pose_at(float time) const;
  // `size`: of the picture, over that at the shutter's opening.
  View view_from(const Pose& pose, double size = 1.0) const;
  View view_at(float time) const;
  Vec3d in_view(const Pose& pose, const Vec3d& way) const;
  Vec2f film_velocity(const Vec3d& from, const Vec3d& to, double frames) const;
  Vec2f panorama_velocity(const Vec3d& from, const Vec3d& to, double frames) const;
  void cast(const View& view, std::span<const Vec2f> film, Ray* out) const;
  void cast(const View& view, std::span<const Vec2f> film, std::span<const Vec2f> lens,
            Ray* out) const;
  void cast_panorama(const View& view, std::span<const Vec2f> film, Ray* out) const;
  float axial_depth(const View& view, const Vec3f& point) const {
    if (shape_.panorama) [[unlikely]]
      return (point - view.position).length();
    return dot(point - view.position, view.axis);
  }

  Shape shape_;
  View view_;                // at the shutter's opening
  Pose pose_;                // then
  std::vector<Step> steps_;  // evenly spaced over the shutter; empty: at rest
  Pose last_;                // of velocity(): as it closes, or a frame later
  // See CameraDescription; null: none.
  std::shared_ptr<const TimeCurve<double>> zoom_;
  double scale_ = 1.0;
  double largest_ = 1.0;    // size of the picture, as view_from counts it
  double last_size_ = 1.0;  // of the picture, as it closes
};

}  // namespace emberline
