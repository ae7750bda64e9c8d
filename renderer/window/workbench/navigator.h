// Moves the camera by drags, wheel, keys and bookmarks. Every move edits the scene's camera. Does
// nothing without a scene.
//
// Used on the window's thread only; nothing here blocks.
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

  // Call when the session has a new scene. `reread` says that the scene is the same file, read
  // again. Bookmarks are then kept.
  void on_new_scene(bool reread);

  // Handles camera drags and Drag::kRotateEnvironment, and ignores other drags. `pixels` is the
  // mouse movement in picture pixels.
  void drag(Drag drag, const Vec2f& pixels);
  void dolly(double steps);  // positive wheel steps move towards the pivot
  // `held` is indexed by Flight.
  void fly(const std::array<bool, 6>& held, double seconds, bool fast);
  // Turns towards the point, and makes it the pivot and the point in focus.
  void look_at(const Vec3d& point);

  bool orthographic() const;
  // Objects at the pivot keep their size. Switching back to perspective restores the last field of
  // view.
  void set_orthographic(bool orthographic);
  void set_mirrored(bool mirrored);
  // Returns the lens's focus distance in metres. By default, this is the distance to the pivot.
  // There must be a scene.
  double focus_distance() const;

  void frame_all();
  void reset();

  // Bookmarks are numbered from 1.
  const std::array<std::optional<CameraEdit>, 9>& bookmarks() const { return bookmarks_; }
  void recall_bookmark(int number);
  void store_bookmark(int number);

 private:
  ViewCamera camera() const;
  void change(const ViewCamera& view, std::string_view what = "camera");

  Workbench& bench_;
  std::array<std::optional<CameraEdit>, 9> bookmarks_;
  Vec3d pivot_ = Vec3d(0.0);
  double perspective_fov_ = kDefaultFov;  // the field of view before switching to orthographic
};

}  // namespace emberline
