// A view that mouse and keys move. The functions convert a scene's camera to such a view, and a
// view to the CameraEdit that reproduces it. They are pure arithmetic.
//
// Everything is in world space, metres and radians; +Y is up, as in glTF. The view moves like a
// turntable: it is described by angles around a pivot on the view's axis, so that many small moves
// never tilt the horizon. A rolled camera keeps its roll, and a mirrored camera stays mirrored. An
// orthographic view is scaled instead of moving closer; its eye matters only because objects behind
// it are invisible. A view straight up or down is valid; its azimuth follows from the direction to
// the picture's right. All values are doubles, and moves are proportional to the distance or the
// frame, so that scenes of any size feel the same.
#pragma once

#include "renderer/core/constants.h"
#include "renderer/core/vector.h"
#include "renderer/description/scene_edits.h"

namespace emberline {

struct ViewCamera {
  Vec3d pivot = Vec3d(0.0);
  double distance = 1.0;   // from eye to pivot, > 0
  double azimuth = 0.0;    // the eye's angle around the pivot: 0 at +Z, pi / 2 at +X
  double elevation = 0.0;  // the eye's angle above the pivot, in [-pi / 2, pi / 2]
  // Counterclockwise angle from the horizon to the picture's right or, if the view is mirrored, to
  // the picture's left.
  double roll = 0.0;
  bool mirrored = false;  // left and right are swapped
  bool orthographic = false;
  double fov_y = 0.7;        // perspective only, in [kMinFov, kMaxFov]
  double half_height = 1.0;  // half the frame's height, orthographic only; > 0
  // Moves keep `distance` or, in an orthographic view, `half_height` within this range.
  double min_distance = 0.0, max_distance = 1e300;

  // Orthonormal directions in world space: the picture's right, the picture's up, and the direction
  // from the pivot to the eye.
  struct Axes {
    Vec3d right, up, back;
  };
  Axes axes() const;
  Vec3d eye() const { return pivot + axes().back * distance; }
  // Return the frame's height at the pivot, and the angle that this height spans at the eye.
  double frame_height() const;
  double frame_angle() const;
  // Moves are proportional to this length: the distance or, for orthographic views, the distance at
  // which a perspective view with kDefaultFov shows the same height.
  double move_scale() const;
};

inline constexpr double kMinFov = 1e-3, kMaxFov = 3.0;  // 0.06 and 172 degrees
// Default field of view when an orthographic view is turned into a perspective one.
inline constexpr double kDefaultFov = kPiD / 6;

// Returns the view of a camera. The pivot lies on the camera's axis, at the depth of the scene's
// `center`, or `radius` away if the centre is behind the camera. `radius` is the radius of the
// scene and must be > 0.
ViewCamera view_of(const CameraDescription& camera, const Vec3d& center, double radius);

// Returns the edit that gives any camera this view. Keeps the other members of `before`, such as
// the file's camera that `before` names.
CameraEdit edit_of(const ViewCamera& view, const CameraEdit& before = {});

// Moves the eye around the pivot, to the picture's right and up. Stops when the view is straight up
// or down.
ViewCamera orbit(ViewCamera view, double azimuth, double elevation);
// Turns the view around the eye, which moves the pivot. `yaw` turns to the picture's left, and
// `pitch` turns upwards.
ViewCamera turn(ViewCamera view, double yaw, double pitch);
// Moves the view so that the scene at the pivot follows the cursor, which has moved to the right
// and down by these fractions of the frame's height.
ViewCamera pan(ViewCamera view, double right, double down);
// Multiplies the distance, or the height of an orthographic frame, by `factor`.
ViewCamera dolly(ViewCamera view, double factor);
// Moves eye and pivot along the picture's axes, in metres. In an orthographic view, `forward`
// enlarges the picture by as much as it would enlarge objects at the pivot in a perspective view.
ViewCamera fly(ViewCamera view, double right, double up, double forward);
// Switch the projection and keep the size of objects at the pivot. to_orthographic() keeps the eye;
// to_perspective() moves it along the axis.
ViewCamera to_orthographic(ViewCamera view);
ViewCamera to_perspective(ViewCamera view, double fov_y);
// Turns towards the point, which becomes the pivot, and keeps the eye. An orthographic view keeps
// its direction instead and is shifted to centre the point. Does nothing if the point is at the
// eye.
ViewCamera look_towards(ViewCamera view, const Vec3d& point);
// Shows a whole sphere from the current direction. `aspect` is the frame's width over its height.
ViewCamera frame_all(ViewCamera view, const Vec3d& center, double radius, double aspect);

}  // namespace emberline
