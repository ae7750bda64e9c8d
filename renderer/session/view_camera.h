// A view as mouse and keys move it: pure arithmetic, from the camera of a scene to the CameraEdit
// that looks the same, and on from there.
//
// World space, metres, radians; +Y is up, as in glTF. The view is a turntable's: angles about a
// pivot that lies on its axis, so that no number of small moves tips the horizon over. A camera
// that is tipped keeps its roll, a mirrored one its mirroring, and an orthographic one is moved as
// one: nearer is larger there, and its eye only says from where on there is anything to be seen.
// Straight up and down are views like any other: the azimuth is
// that of the picture's right edge there. Doubles throughout, and all moves in proportion to the
// distance or the frame, so that scenes of a micrometre and of a thousand kilometres handle alike.
#pragma once

#include "renderer/core/constants.h"
#include "renderer/core/vector.h"
#include "renderer/description/scene_edits.h"

namespace emberline {

struct ViewCamera {
  Vec3d pivot = Vec3d(0.0);
  double distance = 1.0;   // from the eye to the pivot, > 0
  double azimuth = 0.0;    // of the eye about the pivot: 0 at +Z, pi / 2 at +X
  double elevation = 0.0;  // of the eye above the pivot, in [-pi / 2, pi / 2]
  // Angle of the picture's right edge from the horizon, counterclockwise; mirrored, of its left
  // edge.
  double roll = 0.0;
  bool mirrored = false;  // left and right are exchanged
  bool orthographic = false;
  double fov_y = 0.7;        // of perspective, in [kLeastFov, kMostFov]
  double half_height = 1.0;  // of the frame, orthographic; > 0
  // Moves keep the distance, or half the height, between these.
  double least_distance = 0.0, most_distance = 1e300;

  // Orthonormal, world space: the picture's right and up, and from the pivot to the eye.
  struct Axes {
    Vec3d right, up, back;
  };
  Axes axes() const;
  Vec3d eye() const { return pivot + axes().back * distance; }
  // How high the frame is at the pivot, and the angle that this is from the eye.
  double frame_height() const;
  double frame_angle() const;
  // The length that moves are proportional to: the distance, or the one from which a perspective of
  // kOrdinaryFov shows as much.
  double reach() const;
};

inline constexpr double kLeastFov = 1e-3, kMostFov = 3.0;  // 0.06 and 172 degrees
// Field of view for a view that is given a perspective.
inline constexpr double kOrdinaryFov = kPiD / 6;

// The view of a camera; the pivot is on its axis, abreast of the scene's centre, or `radius` away
// where that is behind it. `radius` > 0 is the scene's.
ViewCamera view_of(const CameraDescription& camera, const Vec3d& center, double radius);

// The edit that makes this view of any camera; what else `before` says, the file's camera that it
// names, is kept.
CameraEdit edit_of(const ViewCamera& view, const CameraEdit& before = {});

// About the pivot: the eye to the picture's right, and up. Beyond straight up and down it goes no
// further.
ViewCamera orbit(ViewCamera view, double azimuth, double elevation);
// Turns in place: yaw to the picture's left, pitch upwards; the pivot goes along.
ViewCamera turn(ViewCamera view, double yaw, double pitch);
// Moves the scene at the pivot with the cursor: to the right and down, in frame heights.
ViewCamera pan(ViewCamera view, double right, double down);
// Multiplies the distance, or the height of an orthographic frame: 0.5 goes half of the way to the
// pivot, or shows half as much.
ViewCamera dolly(ViewCamera view, double factor);
// Moves eye and pivot along the picture's axes, in metres. Without perspective nothing comes nearer
// that way, and `forward` enlarges as much as it would at the pivot's distance of reach().
ViewCamera fly(ViewCamera view, double right, double up, double forward);
// Objects at the pivot keep their size: the eye stays for an orthographic view, and moves along the
// axis for a perspective one.
ViewCamera without_perspective(ViewCamera view);
ViewCamera with_perspective(ViewCamera view, double fov_y);
// Turns to the point, which becomes the pivot; the eye stays. An orthographic view is shifted until
// the point is in its middle, and keeps its direction. Does nothing for a point at the eye.
ViewCamera look_towards(ViewCamera view, const Vec3d& point);
// All of a sphere, from where it is looked from now. `aspect`: width over height of the frame.
ViewCamera frame_all(ViewCamera view, const Vec3d& center, double radius, double aspect);

}  // namespace emberline
