// Moving the camera and the light by hand.
#include <algorithm>
#include <cmath>
#include <tuple>

#include "renderer/window/workbench.h"

namespace emberline {
namespace {

constexpr double kTurnPerPixel = 0.25;  // degrees of the environment
constexpr double kTurnPerHeight = 3.0;  // radians of an orbit, by a drag over the frame's height
constexpr double kDollyStep = 0.88;     // of the distance, by one step of the wheel
// Distances to what is looked at, a second.
constexpr double kFlightSpeed = 0.6, kFastFlight = 4.0;

}  // namespace

ViewCamera Workbench::camera() const {
  return view_of(edited_camera(edits_, scene_->outline, scene_->camera), pivot_, scene_->radius);
}

void Workbench::change_view(const ViewCamera& view, std::string_view what) {
  pivot_ = view.pivot;
  change_camera(edit_of(view, edits_.camera), what);
}

void Workbench::navigate(Drag drag, const Vec2f& pixels) {
  if (!scene_) return;
  const double height = settings_.render.height;
  const double x = pixels.x / height, y = pixels.y / height;
  const ViewCamera view = camera();
  switch (drag) {
    case Drag::kOrbit:
      return change_view(orbit(view, -kTurnPerHeight * x, kTurnPerHeight * y));
    case Drag::kPan:
      return change_view(pan(view, x, y));
    case Drag::kDolly:
      return change_view(dolly(view, std::exp2(2.0 * y)));
    case Drag::kLookAround:
      return change_view(turn(view, view.frame_angle() * x, view.frame_angle() * y));
    case Drag::kTurnEnvironment:
      return turn_environment(kTurnPerPixel * pixels.x);
    case Drag::kRegion:
    case Drag::kMovePicture:
      return;
  }
}

void Workbench::turn_environment(double degrees) {
  const std::optional<EnvironmentDescription>& own = scene_->outline.environment;
  SceneEdits edits = edits_;
  EnvironmentEdit& edit = edits.environment;
  if (!own && edit.file.empty()) {
    return say(Message::Level::kNote, "the scene has no environment that could be turned");
  }
  const float before = edit.rotation_degrees.value_or(own ? own->rotation_degrees : 0.0f);
  edit.rotation_degrees = float(std::remainder(before + degrees, 360.0));
  change(edits, "environment rotation");
}

void Workbench::dolly_by(double steps) {
  if (scene_) change_view(dolly(camera(), std::pow(kDollyStep, steps)));
}

void Workbench::fly_along(const std::array<bool, 6>& held, double seconds, bool fast) {
  if (!scene_) return;
  const auto along = [&](Flight forth, Flight back) {
    return double(held[size_t(forth)]) - double(held[size_t(back)]);
  };
  const ViewCamera view = camera();
  // In proportion to what is looked at, so that one slows down on coming near.
  const double way = kFlightSpeed * view.reach() * seconds * (fast ? kFastFlight : 1.0);
  change_view(fly(view, way * along(Flight::kRight, Flight::kLeft),
                  way * along(Flight::kUp, Flight::kDown),
                  way * along(Flight::kForward, Flight::kBack)));
}

double Workbench::focus_distance() const {
  return edits_.camera.focus_distance.value_or(camera().distance);
}

// Orbits around the point from now on, and a lens is focused there.
void Workbench::look_at(const Vec3d& point) {
  const ViewCamera view = look_towards(camera(), point);
  pivot_ = view.pivot;
  CameraEdit edit = edit_of(view, edits_.camera);
  edit.focus_distance.reset();
  change_camera(edit, "look at");
  say(Message::Level::kNote,
      edit.f_stop ? "orbiting around this point, and focused on it" : "orbiting around this point");
}

void Workbench::orbit_around(const Vec2i& pixel) {
  pivot_pixel_ = pixel;
  refresh_inspection();
}

void Workbench::set_orthographic(bool orthographic) {
  if (!scene_) return;
  const ViewCamera view = camera();
  if (view.orthographic == orthographic) return;
  if (orthographic) fov_before_ = view.fov_y;
  change_view(orthographic ? without_perspective(view) : with_perspective(view, fov_before_),
              "projection");
}

void Workbench::set_mirrored(bool mirrored) {
  if (!scene_) return;
  ViewCamera view = camera();
  view.mirrored = mirrored;
  change_view(view, "mirrored");
}

}  // namespace emberline
