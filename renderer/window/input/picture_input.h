// Translates the window system's events into actions on the picture. Every event is handled on
// arrival, so that a click between two frames is not lost.
#pragma once

#include <array>
#include <functional>
#include <optional>

#include "renderer/window/workbench/workbench.h"

namespace emberline {

class PictureInput {
 public:
  // `covered` returns whether a panel, menu or dialog covers a point; `typing` returns whether keys
  // go to a text field or popup.
  PictureInput(Workbench& bench, std::function<bool(const Vec2f&)> covered,
               std::function<bool()> typing);

  // Positions are in window units; keys, buttons and modifiers have GLFW's values.
  void button(int button, bool pressed, int modifiers);
  void moved(const Vec2f& position);
  void left_window();
  void wheel(double steps, int modifiers);
  void key(int key, bool pressed, bool repeated, int modifiers);
  void lost_focus();  // releases all keys, because their actual release is not reported

  // Moves the camera in the direction of the held keys. `seconds` is the time since the last call.
  void fly(double seconds);

  bool dragging() const { return drag_.has_value() && moved_; }
  bool flying() const;
  // Returns the region that the user is drawing, if any.
  std::optional<Rect> dragged_region() const;

 private:
  void click(int modifiers);

  Workbench& bench_;
  std::function<bool(const Vec2f&)> is_covered_;
  std::function<bool()> is_typing_;
  Vec2f position_ = Vec2f(-1.0f), pressed_at_ = Vec2f(0.0f);
  std::optional<Drag> drag_;
  int drag_button_ = -1;
  bool moved_ = false, wiping_ = false;
  double last_click_s_ = -1e9;
  std::array<bool, 6> held_keys_ = {};
  bool fast_ = false;
};

}  // namespace emberline
