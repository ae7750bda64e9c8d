#include "renderer/window/workbench/navigator.h"

#include <fmt/format.h>

#include <cmath>

#include "renderer/window/workbench/workbench.h"

namespace emberline {
namespace {

constexpr double kRotationPerPixel = 0.25;  // degrees of environment rotation
constexpr double kOrbitPerHeight = 3.0;     // radians of orbit for a drag over the frame's height
constexpr double kDollyStep = 0.88;         // factor on the distance per wheel step
// The flight speed per second, relative to the distance to the pivot, and the factor by which Shift
// increases this speed.
constexpr double kFlightSpeed = 0.6, kFastFlight = 4.0;

}  // namespace

void Navigator::on_new_scene(bool reread) {
  if (!reread) bookmarks_ = {};
  pivot_ = bench_.session.scene()->center;
  perspective_fov_ = kDefaultFov;
}

ViewCamera Navigator::camera() const {
  const auto scene = bench_.session.scene();
  return view_of(edited_camera(bench_.session.edits(), scene->outline, scene->camera), pivot_,
                 scene->radius);
}

void Navigator::change(const ViewCamera& view, std::string_view what) {
  pivot_ = view.pivot;
  bench_.edits.change(edit_of(view, bench_.session.edits().camera), what);
}

void Navigator::drag(Drag drag, const Vec2f& pixels) {
  if (!bench_.session.scene()) return;
  const double height = bench_.session.settings().render.height;
  const double x = pixels.x / height, y = pixels.y / height;
  const ViewCamera view = camera();
  switch (drag) {
    case Drag::kOrbit:
      return change(orbit(view, -kOrbitPerHeight * x, kOrbitPerHeight * y));
    case Drag::kPan:
      return change(pan(view, x, y));
    case Drag::kDolly:
      return change(emberline::dolly(view, std::exp2(2.0 * y)));
    case Drag::kLookAround:
      return change(turn(view, view.frame_angle() * x, view.frame_angle() * y));
    case Drag::kRotateEnvironment:
      return bench_.edits.rotate_environment(kRotationPerPixel * pixels.x);
    case Drag::kRegion:
    case Drag::kMovePicture:
      return;
  }
}

void Navigator::dolly(double steps) {
  if (bench_.session.scene()) change(emberline::dolly(camera(), std::pow(kDollyStep, steps)));
}

void Navigator::fly(const std::array<bool, 6>& held, double seconds, bool fast) {
  if (!bench_.session.scene()) return;
  const auto axis_value = [&](Flight positive, Flight negative) {
    return double(held[size_t(positive)]) - double(held[size_t(negative)]);
  };
  const ViewCamera view = camera();
  // The speed is proportional to the distance to the pivot, so that flight slows down near objects.
  const double distance = kFlightSpeed * view.move_scale() * seconds * (fast ? kFastFlight : 1.0);
  change(emberline::fly(view, distance * axis_value(Flight::kRight, Flight::kLeft),
                        distance * axis_value(Flight::kUp, Flight::kDown),
                        distance * axis_value(Flight::kForward, Flight::kBack)));
}

void Navigator::look_at(const Vec3d& point) {
  if (!bench_.session.scene()) return;
  const ViewCamera view = look_towards(camera(), point);
  pivot_ = view.pivot;
  CameraEdit edit = edit_of(view, bench_.session.edits().camera);
  edit.focus_distance.reset();
  bench_.edits.change(edit, "look at");
  bench_.messages.note(edit.f_stop ? "Orbiting around this point, in focus"
                                   : "Orbiting around this point");
}

bool Navigator::orthographic() const { return bench_.session.scene() && camera().orthographic; }

void Navigator::set_orthographic(bool orthographic) {
  if (!bench_.session.scene()) return;
  const ViewCamera view = camera();
  if (view.orthographic == orthographic) return;
  if (orthographic) perspective_fov_ = view.fov_y;
  change(orthographic ? to_orthographic(view) : to_perspective(view, perspective_fov_),
         "projection");
}

void Navigator::set_mirrored(bool mirrored) {
  if (!bench_.session.scene()) return;
  ViewCamera view = camera();
  view.mirrored = mirrored;
  change(view, "mirrored");
}

double Navigator::focus_distance() const {
  return bench_.session.edits().camera.focus_distance.value_or(camera().distance);
}

void Navigator::frame_all() {
  const auto scene = bench_.session.scene();
  if (!scene) return;
  const RenderOptions& frame = bench_.session.settings().render;
  change(emberline::frame_all(camera(), scene->center, scene->radius,
                              double(frame.width) / frame.height));
}

void Navigator::reset() {
  if (const auto scene = bench_.session.scene()) pivot_ = scene->center;
  bench_.edits.change(CameraEdit(), "reset camera");
}

void Navigator::recall_bookmark(int number) {
  if (const auto& camera = bookmarks_[size_t(number - 1)]) {
    return bench_.edits.change(*camera, "bookmark");
  }
  bench_.messages.note(
      fmt::format("Bookmark {} is empty. Press Ctrl+{} to store the view.", number, number));
}

void Navigator::store_bookmark(int number) {
  if (!bench_.session.scene()) return;
  bookmarks_[size_t(number - 1)] = bench_.session.edits().camera;
  bench_.messages.note(fmt::format("Stored the view as bookmark {}", number));
}

}  // namespace emberline
