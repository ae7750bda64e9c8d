// Moves the camera by hand: drags, wheel, keys, bookmarks. Every move is an edit of the scene's
// camera, in proportion to the distance of what is looked at. Without a scene nothing moves.
//
// The window's thread only; nothing here blocks it.
#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "renderer/session/view_camera.h"
#include "renderer/window/input/input.h"

namespace emberline {

class Workbench;

class Navigator {
 public:
  explicit Navigator(Workbench& bench) : bench_(bench) {}

  // The session has a new scene. `reread`: the same file again, whose bookmarks stay.
  void scene_arrived(bool reread);

  // `pixels`: the way of the mouse, in the picture's own pixels. Drags that move no camera but the
  // light turn the environment; the others do nothing.
  void drag(Drag drag, const Vec2f& pixels);
  void dolly(double steps);  // of the wheel, towards the scene
  // `held`: by Flight.
  void fly(const std::array<bool, 6>& held, double seconds, bool fast);
  // Orbits around the point from now on, and focuses a lens there.
  void look_at(const Vec3d& point);

  bool orthographic() const;
  // Objects at the pivot keep their size. Perspective returns with its last angle.
  void set_orthographic(bool orthographic);
  void set_mirrored(bool mirrored);
  // The distance that the lens is focused at, in metres; if none is set, the distance to the point
  // that is orbited. Needs a scene.
  double focus_distance() const;

  void frame_all();
  void reset();

  // Bookmark 1 is the first in the list.
  const std::array<std::optional<CameraEdit>, 9>& bookmarks() const { return bookmarks_; }
  void recall_bookmark(int number);
  void store_bookmark(int number);

 private:
  ViewCamera camera() const;
  void change(const ViewCamera& view, std::string_view what = "camera");

  Workbench& bench_;
  std::array<std::optional<CameraEdit>, 9> bookmarks_;
  Vec3d pivot_ = Vec3d(0.0);
  double fov_before_ = kOrdinaryFov;  // before the view became orthographic
};

}  // namespace emberline
