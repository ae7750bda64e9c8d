// The picture's position in the window: fitted, or at a chosen zoom in screen pixels per picture
// pixel. Needs no window library, so that it can be tested without one.
//
// Screen coordinates are frame-buffer pixels from the window's upper left corner, y down. Picture
// coordinates are frame pixels; (0, 0) is the upper left corner, and pixel (x, y) covers [x, x + 1)
// x [y, y + 1).
#pragma once

#include <optional>

#include "renderer/core/rect.h"
#include "renderer/core/vector.h"

namespace emberline {

class PicturePlacement {
 public:
  static constexpr double kMinZoom = 1.0 / 32.0, kMaxZoom = 32.0;

  // Sets the available part of the window and the frame's size. Keeps the zoom and the centre.
  void place(const Rect& area, int width, int height);

  // Fits the whole picture into the area, now and whenever the area changes.
  void fit();
  bool fitted() const { return fitted_; }
  // `zoom` is clamped. The point of the picture that is at `screen` stays there.
  void zoom_to(double zoom, const Vec2f& screen);
  void zoom_to(double zoom);  // around the centre of the area
  // Moves the picture with the mouse.
  void drag(const Vec2f& screen_delta);

  double zoom() const { return zoom_; }
  const Rect& area() const { return area_; }
  Vec2f to_screen(const Vec2f& picture) const;
  Vec2f to_picture(const Vec2f& screen) const;
  // Returns the pixel under a screen point, or nullopt if the point is outside the picture or the
  // area.
  std::optional<Vec2i> pixel_at(const Vec2f& screen) const;

 private:
  void apply_fit();
  void keep_visible();

  Rect area_;
  int width_ = 0, height_ = 0;
  double zoom_ = 1.0;
  double left_ = 0.0, top_ = 0.0;  // the picture's edges in screen coordinates
  bool fitted_ = true;
};

}  // namespace emberline
