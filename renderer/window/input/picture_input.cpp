#include "renderer/window/input/picture_input.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <algorithm>
#include <cmath>

#include "renderer/window/workbench/clock.h"

namespace emberline {
namespace {

constexpr float kClickSlack = 4.0f;         // a press that moves less is a click, not a drag
constexpr double kDoubleClick_s = 0.35;     // longest time between the two clicks
constexpr float kWipeGrip = 6.0f;           // maximum distance for grabbing the wipe's line
constexpr double kWheelZoom = 1.189207115;  // zoom factor per step of the wheel, 2^(1/4)
constexpr int kModifiers = GLFW_MOD_SHIFT | GLFW_MOD_CONTROL | GLFW_MOD_ALT;

}  // namespace

PictureInput::PictureInput(Workbench& bench, std::function<bool(const Vec2f&)> covered,
                           std::function<bool()> typing)
    : bench_(bench), is_covered_(std::move(covered)), is_typing_(std::move(typing)) {}

void PictureInput::button(int button, bool pressed, int modifiers) {
  if (!pressed) {
    if (button != drag_button_) return;
    const std::optional<Rect> region = dragged_region();
    if (region && !region->empty()) {
      bench_.settings.change_with([&](ViewSettings& s) { s.region = region; });
    } else if (!moved_ && !wiping_ && drag_) {
      click(modifiers & kModifiers);
    }
    drag_.reset();
    drag_button_ = -1;
    wiping_ = false;
    return;
  }
  const Rect& area = bench_.placement.area();
  if (drag_ || wiping_ || is_covered_(position_) ||
      !area.contains(int(position_.x), int(position_.y))) {
    return;
  }
  drag_button_ = button;
  moved_ = false;
  pressed_at_ = position_;
  const Comparison& comparison = bench_.comparison;
  if (comparison.wipe() != Wipe::kNone && button == GLFW_MOUSE_BUTTON_LEFT && bench_.picture()) {
    const Vec2f line(comparison.wipe_position() * float(bench_.picture()->width), 0.0f);
    wiping_ = std::abs(position_.x - bench_.placement.to_screen(line).x) <= kWipeGrip;
    if (wiping_) return;
  }
  if (const DragGesture* gesture = find_drag(button, modifiers & kModifiers)) {
    drag_ = gesture->drag;
  }
}

void PictureInput::moved(const Vec2f& position) {
  const Vec2f delta = position - position_;
  position_ = position;
  if (wiping_ && bench_.picture()) {
    const float x = bench_.placement.to_picture(position).x;
    return bench_.comparison.set_wipe_position(x / float(bench_.picture()->width));
  }
  const Rect& area = bench_.placement.area();
  const bool is_over_picture =
      area.contains(int(position.x), int(position.y)) && !is_covered_(position);
  if (!drag_) {
    bench_.pixels.set_cursor_pixel(is_over_picture ? bench_.placement.pixel_at(position)
                                                   : std::nullopt);
    return;
  }
  if (!moved_) {
    if ((position - pressed_at_).length() < kClickSlack) return;
    moved_ = true;
    bench_.pixels.set_cursor_pixel(std::nullopt);
  }
  if (*drag_ == Drag::kMovePicture) return bench_.placement.drag(delta);
  if (*drag_ != Drag::kRegion)
    bench_.navigator.drag(*drag_, delta / float(bench_.placement.zoom()));
}

void PictureInput::left_window() {
  if (!drag_) bench_.pixels.set_cursor_pixel(std::nullopt);
}

void PictureInput::click(int modifiers) {
  const std::optional<Vec2i> pixel = bench_.placement.pixel_at(pressed_at_);
  if (!pixel || drag_button_ != GLFW_MOUSE_BUTTON_LEFT) return;
  if (modifiers & GLFW_MOD_CONTROL) return bench_.act(Action::kClearRegion);
  const double now = window_time_s();
  if (now - last_click_s_ < kDoubleClick_s) {
    bench_.pixels.orbit_around(*pixel);
  } else {
    bench_.pixels.select_at(*pixel);
  }
  last_click_s_ = now;
}

void PictureInput::wheel(double steps, int modifiers) {
  if (is_covered_(position_) ||
      !bench_.placement.area().contains(int(position_.x), int(position_.y))) {
    return;
  }
  if (modifiers & GLFW_MOD_CONTROL) {
    bench_.placement.zoom_to(bench_.placement.zoom() * std::pow(kWheelZoom, steps), position_);
  } else {
    bench_.navigator.dolly(steps);
  }
}

void PictureInput::key(int key, bool pressed, bool repeated, int modifiers) {
  fast_ = (modifiers & GLFW_MOD_SHIFT) != 0;
  const auto flight = std::ranges::find(flight_table(), key, &FlightKey::key);
  const bool in_text_field = is_typing_();
  if (flight != flight_table().end() &&
      (!pressed || (!in_text_field && !(modifiers & (GLFW_MOD_CONTROL | GLFW_MOD_ALT))))) {
    held_keys_[size_t(flight->flight)] = pressed;
    if (pressed) return;
  }
  if (!pressed || in_text_field) return;
  const Shortcut* shortcut = find_shortcut(key, modifiers & kModifiers);
  if (!shortcut) return;
  const Action action = shortcut->action;
  const bool may_repeat = action == Action::kUndo || action == Action::kRedo ||
                          action == Action::kZoomIn || action == Action::kZoomOut ||
                          action == Action::kExposureUp || action == Action::kExposureDown;
  if (!repeated || may_repeat) bench_.act(action, shortcut->number_of(key));
}

void PictureInput::lost_focus() { held_keys_ = {}; }

bool PictureInput::flying() const {
  return std::ranges::find(held_keys_, true) != held_keys_.end();
}

void PictureInput::fly(double seconds) {
  if (flying()) bench_.navigator.fly(held_keys_, seconds, fast_);
}

std::optional<Rect> PictureInput::dragged_region() const {
  if (drag_ != Drag::kRegion || !moved_) return std::nullopt;
  const Vec2f a = bench_.placement.to_picture(pressed_at_);
  const Vec2f b = bench_.placement.to_picture(position_);
  const RenderOptions& options = bench_.session.settings().render;
  const Rect frame{0, 0, options.width, options.height};
  return Rect{int(std::floor(std::min(a.x, b.x))), int(std::floor(std::min(a.y, b.y))),
              int(std::ceil(std::max(a.x, b.x))), int(std::ceil(std::max(a.y, b.y)))}
      .intersect(frame);
}

}  // namespace emberline
