#include "renderer/window/workbench/navigator.h"

#include <fmt/format.h>

#include <cmath>

namespace emberline {
namespace {

constexpr double kTurnPerPixel = 0.25;  // degrees of the environment
constexpr double kTurnPerHeight = 3.0;  // radians of an orbit, by a drag over the frame's height
constexpr double kDollyStep = 0.88;     // of the distance, by one step of the wheel
// Distances to what is looked at, a second.
constexpr double kFlightSpeed = 0.6, kFastFlight = 4.0;

}  // namespace

Navigator::Navigator(const RenderSession& session, SceneEditor& edits, MessageLog& messages)
    : session_(session), edits_(edits), messages_(messages) {}

void Navigator::scene_arrived(bool reread) {
  if (!reread) bookmarks_ = {};
  pivot_ = session_.scene()->center;
  fov_before_ = kOrdinaryFov;
}

ViewCamera Navigator::camera() const {
  const auto scene = session_.scene();
  return view_of(edited_camera(session_.edits(), scene->outline, scene->camera), pivot_,
                 scene->radius);
}

void Navigator::change(const ViewCamera& view, std::string_view what) {
  pivot_ = view.pivot;
  edits_.change(edit_of(view, session_.edits().camera), what);
}

void Navigator::drag(Drag drag, const Vec2f& pixels) {
  if (!session_.scene()) return;
  const double height = session_.settings().render.height;
  const double x = pixels.x / height, y = pixels.y / height;
  const ViewCamera view = camera();
  switch (drag) {
    case Drag::kOrbit:
      return change(orbit(view, -kTurnPerHeight * x, kTurnPerHeight * y));
    case Drag::kPan:
      return change(pan(view, x, y));
    case Drag::kDolly:
      return change(emberline::dolly(view, std::exp2(2.0 * y)));
    case Drag::kLookAround:
      return change(turn(view, view.frame_angle() * x, view.frame_angle() * y));
    case Drag::kTurnEnvironment:
      return edits_.turn_environment(kTurnPerPixel * pixels.x);
    case Drag::kRegion:
    case Drag::kMovePicture:
      return;
  }
}

void Navigator::dolly(double steps) {
  if (session_.scene()) change(emberline::dolly(camera(), std::pow(kDollyStep, steps)));
}

void Navigator::fly(const std::array<bool, 6>& held, double seconds, bool fast) {
  if (!session_.scene()) return;
  const auto along = [&](Flight forth, Flight back) {
    return double(held[size_t(forth)]) - double(held[size_t(back)]);
  };
  const ViewCamera view = camera();
  // In proportion to what is looked at, so that one slows down on coming near.
  const double way = kFlightSpeed * view.reach() * seconds * (fast ? kFastFlight : 1.0);
  change(emberline::fly(view, way * along(Flight::kRight, Flight::kLeft),
                        way * along(Flight::kUp, Flight::kDown),
                        way * along(Flight::kForward, Flight::kBack)));
}

void Navigator::look_at(const Vec3d& point) {
  if (!session_.scene()) return;
  const ViewCamera view = look_towards(camera(), point);
  pivot_ = view.pivot;
  CameraEdit edit = edit_of(view, session_.edits().camera);
  edit.focus_distance.reset();
  edits_.change(edit, "look at");
  messages_.note(edit.f_stop ? "orbiting around this point, and focused on it"
                             : "orbiting around this point");
}

bool Navigator::orthographic() const { return session_.scene() && camera().orthographic; }

void Navigator::set_orthographic(bool orthographic) {
  if (!session_.scene()) return;
  const ViewCamera view = camera();
  if (view.orthographic == orthographic) return;
  if (orthographic) fov_before_ = view.fov_y;
  change(orthographic ? without_perspective(view) : with_perspective(view, fov_before_),
         "projection");
}

void Navigator::set_mirrored(bool mirrored) {
  if (!session_.scene()) return;
  ViewCamera view = camera();
  view.mirrored = mirrored;
  change(view, "mirrored");
}

double Navigator::focus_distance() const {
  return session_.edits().camera.focus_distance.value_or(camera().distance);
}

void Navigator::frame_all() {
  const auto scene = session_.scene();
  if (!scene) return;
  const RenderOptions& frame = session_.settings().render;
  change(emberline::frame_all(camera(), scene->center, scene->radius,
                              double(frame.width) / frame.height));
}

void Navigator::reset() {
  if (const auto scene = session_.scene()) pivot_ = scene->center;
  edits_.change(CameraEdit(), "reset camera");
}

void Navigator::recall_bookmark(int number) {
  if (const auto& camera = bookmarks_[size_t(number - 1)]) {
    return edits_.change(*camera, "bookmark");
  }
  messages_.note(fmt::format("bookmark {} is empty; Ctrl+{} stores the view", number, number));
}

void Navigator::store_bookmark(int number) {
  if (!session_.scene()) return;
  bookmarks_[size_t(number - 1)] = session_.edits().camera;
  messages_.note(fmt::format("stored as bookmark {}", number));
}

}  // namespace emberline
