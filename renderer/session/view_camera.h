// A view that is moved by mouse and keys: pure arithmetic between a scene's camera and the
// CameraEdit that reproduces the view.
//
// World space, metres, radians; +Y is up, as in glTF. The view is a turntable: angles around a
// pivot on its axis, so that many small moves never tilt the horizon. A rolled camera keeps its
// roll and a mirrored one stays mirrored. An orthographic view moves closer by scaling; its eye
// only determines the near limit of visibility. Straight up and down are regular views, where the
// azimuth is that of the picture's right edge. All values are doubles, and moves scale with the
// distance or the frame, so that scenes of any size handle alike.
#pragma once

#include "renderer/core/constants.h"
#include "renderer/core/vector.h"
#include "renderer/description/scene_edits.h"

namespace emberline {

struct ViewCamera {
  Vec3d pivot = Vec3d(0.0);
  double distance = 1.0;   // from eye to pivot, > 0
  double azimuth = 0.0;    // of the eye around the pivot: 0 at +Z, pi / 2 at +X
  double elevation = 0.0;  // of the eye above the pivot, in [-pi / 2, pi / 2]
  // Angle of the picture's right edge (if mirrored, of its left edge) from the horizon,
  // counterclockwise.
  double roll = 0.0;
  bool mirrored = false;  // left and right are swapped
  bool orthographic = false;
  double fov_y = 0.7;        // perspective only, in [kMinFov, kMaxFov]
  double half_height = 1.0;  // of the frame, orthographic only; > 0
  // Moves keep the distance, or half_height, in this range.
  double min_distance = 0.0, max_distance = 1e300;

  // Orthonormal, world space: the picture's right and up, and the direction from pivot to eye.
  struct Axes {
    Vec3d right, up, back;
  };
  Axes axes() const;
  Vec3d eye() const { return pivot + axes().back * distance; }
  // Height of the frame at the pivot, and the angle that it spans at the eye.
  double frame_height() const;
  double frame_angle() const;
  // The length that moves are proportional to: the distance, or for orthographic views the distance
  // at which a perspective view with kDefaultFov shows the same height.
  double move_scale() const;
};

inline constexpr double kMinFov = 1e-3, kMaxFov = 3.0;  // 0.06 and 172 degrees
// Field of view for an orthographic view that becomes a perspective one.
inline constexpr double kDefaultFov = kPiD / 6;

// The view of a camera. The pivot is on its axis at the depth of the scene's centre, or `radius`
// away if that is behind the camera. `radius` > 0 is the scene's.
ViewCamera view_of(const CameraDescription& camera, const Vec3d& center, double radius);

// The edit that gives any camera this view. Other members of `before`, such as the file's camera
// that it names, are kept.
CameraEdit edit_of(const ViewCamera& view, const CameraEdit& before = {});

// Moves the eye around the pivot, to the picture's right and up; stops at straight up and down.
ViewCamera orbit(ViewCamera view, double azimuth, double elevation);
// Turns in place: yaw to the picture's left, pitch upwards; the pivot moves along.
ViewCamera turn(ViewCamera view, double yaw, double pitch);
// Moves the scene at the pivot with the cursor: right and down, in frame heights.
ViewCamera pan(ViewCamera view, double right, double down);
// Multiplies the distance, or the height of an orthographic frame, by `factor`.
ViewCamera dolly(ViewCamera view, double factor);
// Moves eye and pivot along the picture's axes, in metres. In an orthographic view, `forward`
// enlarges the picture as much as it would a perspective one at the distance of the pivot.
ViewCamera fly(ViewCamera view, double right, double up, double forward);
// Switch the projection and keep the size of objects at the pivot. The eye stays when perspective
// is removed, and moves along the axis when it is added.
ViewCamera to_orthographic(ViewCamera view);
ViewCamera to_perspective(ViewCamera view, double fov_y);
// Turns to the point, which becomes the pivot; the eye stays. An orthographic view keeps its
// direction and is shifted to centre the point. Does nothing for a point at the eye.
ViewCamera look_towards(ViewCamera view, const Vec3d& point);
// Shows a whole sphere from the current direction. `aspect`: width over height of the frame.
ViewCamera frame_all(ViewCamera view, const Vec3d& center, double radius, double aspect);

}  // namespace emberline
