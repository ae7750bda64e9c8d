// Moves the camera by drags, wheel, keys and bookmarks. Every move edits the scene's camera, in
// proportion to the distance of the pivot. Does nothing without a scene.
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

  // The session has a new scene. `reread`: the same file again, so bookmarks are kept.
  void on_new_scene(bool reread);

  // `pixels`: the mouse movement in picture pixels. Handles camera drags and
  // Drag::kRotateEnvironment, and ignores others.
  void drag(Drag drag, const Vec2f& pixels);
  void dolly(double steps);  // wheel steps, towards the scene
  // `held` is indexed by Flight.
  void fly(const std::array<bool, 6>& held, double seconds, bool fast);
  // Makes the point the pivot, and focuses the lens there.
  void look_at(const Vec3d& point);

  bool orthographic() const;
  // Objects at the pivot keep their size. Perspective is restored with its last angle.
  void set_orthographic(bool orthographic);
  void set_mirrored(bool mirrored);
  // The lens's focus distance in metres; by default the distance to the pivot. Needs a scene.
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
  double perspective_fov_ = kDefaultFov;  // before the view became orthographic
};

}  // namespace emberline
