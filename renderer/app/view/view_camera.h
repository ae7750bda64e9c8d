// A view as mouse and keys move it: pure arithmetic, from the camera of a scene to the CameraEdit
// that looks the same, and on from there.
//
// World space, metres, radians; +Y is up, as in glTF. The view is a turntable's: angles about a
// pivot that lies on its axis, so that no number of small moves tips the horizon over. A camera
// that is tipped keeps its roll. Straight up and down are views like any other: the azimuth is
// that of the picture's right edge there. Doubles throughout, and all moves in proportion to the
// distance or the frame, so that scenes of a micrometre and of a thousand kilometres handle alike.
#pragma once

#include "renderer/core/vector.h"
#include "renderer/scene/scene_edits.h"

namespace emberline {

struct ViewCamera {
  Vec3d pivot = Vec3d(0.0);
  double distance = 1.0;   // from the eye to the pivot, > 0
  double azimuth = 0.0;    // of the eye about the pivot: 0 at +Z, pi / 2 at +X
  double elevation = 0.0;  // of the eye above the pivot, in [-pi / 2, pi / 2]
  double roll = 0.0;       // of the picture's right edge from the horizon, counterclockwise
  double fov_y = 0.7;      // in [kLeastFov, kMostFov]
  // Moves keep the distance between these.
  double least_distance = 0.0, most_distance = 1e300;

  // Orthonormal, world space: the picture's right and up, and from the pivot to the eye.
  struct Axes {
    Vec3d right, up, back;
  };
  Axes axes() const;
  Vec3d eye() const { return pivot + axes().back * distance; }
};

inline constexpr double kLeastFov = 1e-3, kMostFov = 3.0;  // 0.06 and 172 degrees

// The view of a camera; the pivot is on its axis, abreast of the scene's centre, or `radius` away
// where that is behind it. `radius` > 0 is the scene's. An orthographic camera becomes a
// perspective one of 30 degrees that shows the same at the pivot.
ViewCamera view_of(const CameraDescription& camera, const Vec3d& center, double radius);

// The edit that makes this view of any camera; what else `before` says, the file's camera that it
// names, is kept.
CameraEdit edit_of(const ViewCamera& view, const CameraEdit& before = {});

// About the pivot. Beyond straight up and down it goes no further.
ViewCamera orbit(ViewCamera view, double azimuth, double elevation);
// Turns in place: yaw to the left, pitch upwards; the pivot goes along.
ViewCamera turn(ViewCamera view, double yaw, double pitch);
// Moves the scene at the pivot with the cursor: to the right and down, in frame heights.
ViewCamera pan(ViewCamera view, double right, double down);
// Multiplies the distance: 0.5 goes half of the way to the pivot.
ViewCamera dolly(ViewCamera view, double factor);
// Moves eye and pivot along the picture's axes, in metres.
ViewCamera fly(ViewCamera view, double right, double up, double forward);
ViewCamera with_fov(ViewCamera view, double fov_y);
// Turns to the point, which becomes the pivot; the eye stays. Nothing for a point where the eye is.
ViewCamera look_towards(ViewCamera view, const Vec3d& point);
// Orbits and pans about a point's depth from now on; the picture stays.
ViewCamera with_pivot_at(ViewCamera view, const Vec3d& point);
// All of a sphere, from where it is looked from now. `aspect`: width over height of the frame.
ViewCamera frame_all(ViewCamera view, const Vec3d& center, double radius, double aspect);

}  // namespace emberline
