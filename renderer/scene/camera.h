// Generates camera rays for a pinhole, an orthographic view, a thin lens or a panorama. A panorama
// shows all directions from one point on a latitude-longitude map in world axes, laid out like
// EnvironmentDescription, regardless of the camera's orientation.
//
// The lens follows R. Cook, T. Porter, L. Carpenter, "Distributed Ray Tracing" (SIGGRAPH 1984): all
// light that comes from a point in the plane of focus and passes through the lens meets in one
// point of the film. Terms follow C. Kolb, D. Mitchell, P. Hanrahan, "A Realistic Camera Model for
// Computer Graphics" (SIGGRAPH 1995), section 3. The picture is framed as by a pinhole at the
// lens's centre, so the framing does not change with the focus distance. There is no vignetting.
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
  // The frame has width x height pixels. `origin` and `scale` define internal space: internal =
  // (world - origin) * scale. `max_origin` limits ray origins (Scene::max_origin). Throws
  // InputError for a camera without a direction, for a lens without a focus distance, and for rays
  // beyond float's range.
  Camera(const CameraDescription& description, int width, int height, const Vec3d& origin,
         double scale, double max_origin = kMaxOrigin);

  // `film` contains continuous pixel coordinates, with (0, 0) at the frame's top-left corner and y
  // downwards. Takes at most kRayBatch points, so that the arithmetic vectorises. Each ray depends
  // only on its own point.
  void rays(std::span<const Vec2f> film, Ray* out) const { generate_rays(view_, film, out); }
  // Returns whether there is a lens. If so, rays need lens samples.
  bool has_lens() const { return shape_.lens; }
  // Computes rays through the lens. `lens` contains one sample per film point, uniform in the unit
  // square.
  void rays(std::span<const Vec2f> film, std::span<const Vec2f> lens, Ray* out) const {
    generate_rays(view_, film, lens, out);
  }
  // Returns the ray through the lens's centre.
  Ray ray(const Vec2f& film) const {
    Ray result;
    rays({&film, 1}, &result);
    return result;
  }

  // Returns whether the camera moves or zooms while the shutter is open. The functions above use
  // the camera's state at shutter open.
  bool moves() const { return zoom_ || !steps_.empty(); }
  // Returns the ray at a shutter time in [0, 1]. `lens` is a sample as for rays(); it is ignored if
  // the camera has no lens.
  Ray ray(const Vec2f& film, const Vec2f& lens, float time) const;

  // Returns the bounds of ray origins in internal space while the shutter is open, for film points
  // in an area twice as wide and high as the frame.
  Imath::Box3f origin_bounds() const;

  // Returns whether the camera is a perspective pinhole that does not move while the shutter is
  // open. pixel_size() and project_to_film() require this.
  bool is_static_pinhole() const {
    return !shape_.orthographic && !shape_.panorama && !shape_.lens && !moves();
  }
  bool is_panorama() const { return shape_.panorama; }
  const Vec3d& position() const { return pose_.position; }
  // Returns the width and height of a pixel at distance 1.
  Imath::V2d pixel_size() const { return {shape_.per_column, -shape_.per_row}; }
  // Returns (x * depth, y * depth, depth) of a point in internal space, with x and y in pixels.
  Vec3d project_to_film(const Vec3d& point) const;

  // The matrices from world space that an OpenEXR header contains (worldToCamera and worldToNDC),
  // at shutter open. `origin` is Scene::origin(). to_camera gives the components to the right, up
  // and ahead. After division by w, to_ndc maps the frame's upper left corner to (0, 0) and its
  // lower right corner to (1, 1), and z is 1 / depth. For an orthographic camera, z is the depth.
  // Panoramas have no such matrices, because their projection is not a matrix.
  struct WorldMatrices {
    Mat44d to_camera, to_ndc;
  };
  WorldMatrices world_matrices(const Vec3d& origin) const;

  // Returns the distance from the lens plane along the viewing axis or, for a panorama, the
  // distance from the camera.
  float axial_depth(const Vec3f& point, float time) const {
    if (moves()) [[unlikely]]
      return axial_depth(view_at(time), point);
    return axial_depth(view_, point);
  }

  // Returns the film velocity of a point in pixels per frame, to the right and up. The point is at
  // `from` at shutter open, and at `to` at shutter close, `frames` frames later. With an instant
  // shutter, these times are the rendered instant and one frame later
  // (CameraDescription::next_frame). The point is seen through the lens's centre. Where the depth
  // is less than a hundredth of the depth at the farther end, the path is cut off. The result fits
  // a half float. In a panorama, the motion takes the shorter way round.
  Vec2f velocity(const Vec3d& from, const Vec3d& to, double frames) const;
  // Returns the film velocity that the camera's rotation gives to a point at infinity.
  Vec2f velocity(const Vec3d& direction, double frames) const;

 private:
  // Position and orientation in internal space; right, up and -axis form a right-handed frame.
  struct Pose {
    Vec3d position, right, up, axis;
  };
  struct Step {
    Vec3d position;
    Imath::Quatd rotation;
  };
  // The constant parameters. `half_width` and `half_height` are half the image size at shutter open
  // (perspective: at distance 1). `per_column` and `per_row` are the steps between pixels. `handed`
  // is -1 for a mirrored image, otherwise 1.
  struct Shape {
    bool orthographic = false, panorama = false;
    double width = 1.0, height = 1.0;  // frame size in pixels; only panoramas use it
    Vec2f turns_per_pixel = Vec2f(0.0f);
    double half_width = 1.0, half_height = 1.0, per_column = 1.0, per_row = -1.0, handed = 1.0;
    bool lens = false;
    double lens_radius = 0.0;
    float inverse_focus_distance = 0.0f;  // 1 / distance of the plane of focus; 0: infinity
  };
  // The camera's pose and shape at one time.
  struct View {
    Vec3f position = Vec3f(0.0f);
    Vec3f axis = Vec3f(0.0f, 0.0f, -1.0f);
    // Direction (perspective) or offset (orthographic) of the film point (0, 0), and its change per
    // pixel to the right and down.
    Vec3f corner = Vec3f(0.0f);
    Vec3f per_x = Vec3f(0.0f), per_y = Vec3f(0.0f);
    Vec3f lens_x = Vec3f(0.0f), lens_y = Vec3f(0.0f);  // lens radius, as vectors
  };

  // Returns half the image height. `size` is the vertical field of view or, if the camera is
  // orthographic, the magnification.
  double half_height_of(double size, double scale) const;
  Pose pose_of(const Mat44d& to_world, const std::string& name, const Vec3d& origin, double scale,
               double max_origin) const;
  Pose pose_at(float time) const;
  // `size` is the image size relative to its value at shutter open.
  View view_from(const Pose& pose, double size = 1.0) const;
  View view_at(float time) const;
  Vec3d to_view_space(const Pose& pose, const Vec3d& displacement) const;
  Vec2f film_velocity(const Vec3d& from, const Vec3d& to, double frames) const;
  Vec2f panorama_velocity(const Vec3d& from, const Vec3d& to, double frames) const;
  void generate_rays(const View& view, std::span<const Vec2f> film, Ray* out) const;
  void generate_rays(const View& view, std::span<const Vec2f> film, std::span<const Vec2f> lens,
                     Ray* out) const;
  void generate_panorama_rays(const View& view, std::span<const Vec2f> film, Ray* out) const;
  float axial_depth(const View& view, const Vec3f& point) const {
    if (shape_.panorama) [[unlikely]]
      return (point - view.position).length();
    return dot(point - view.position, view.axis);
  }

  Shape shape_;
  View view_;                // at shutter open
  Pose pose_;                // at shutter open
  std::vector<Step> steps_;  // evenly spaced over the shutter; empty if at rest
  Pose end_pose_;            // for velocity(): at shutter close, or one frame later
  // See CameraDescription; may be null.
  std::shared_ptr<const TimeCurve<double>> zoom_;
  double scale_ = 1.0;
  double max_size_ = 1.0;  // largest relative image size, as in view_from()
  double end_size_ = 1.0;  // relative image size at shutter close
};

}  // namespace emberline
