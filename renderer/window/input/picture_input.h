// From the window system's events to what they mean for the picture. Every event is taken as it
// comes, not once a frame: a click that begins and ends between two frames is one.
#pragma once

#include <array>
#include <functional>
#include <optional>

#include "renderer/window/workbench/workbench.h"

namespace emberline {

class PictureInput {
 public:
  // `covered`: whether a point belongs to the interface; `typing`: whether letters are text.
  PictureInput(Workbench& bench, std::function<bool(const Vec2f&)> covered,
               std::function<bool()> typing);

  // Positions in the window's units; keys, buttons and modifiers as GLFW has them.
  void button(int button, bool pressed, int modifiers);
  void moved(const Vec2f& position);
  void left_window();
  void wheel(double steps, int modifiers);
  void key(int key, bool pressed, bool repeated, int modifiers);
  void lost_focus();  // releases of keys are not reported any more

  // For the time since the last call: keys that are held fly.
  void fly(double seconds);

  bool dragging() const { return drag_.has_value() && moved_; }
  bool flying() const;
  // While a region is being drawn.
  std::optional<Rect> dragged_region() const;

 private:
  void click(int modifiers);

  Workbench& bench_;
  std::function<bool(const Vec2f&)> covered_;
  std::function<bool()> typing_;
  Vec2f position_ = Vec2f(-1.0f), pressed_at_ = Vec2f(0.0f);
  std::optional<Drag> drag_;
  int drag_button_ = -1;
  bool moved_ = false, wiping_ = false;
  double last_click_s_ = -1e9;
  std::array<bool, 6> held_ = {};
  bool fast_ = false;
};

}  // namespace emberline
