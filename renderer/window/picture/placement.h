// Where the picture lies in the window: fitted, or at a chosen zoom in screen pixels per picture
// pixel. No window library, so that its arithmetic is tested alone.
//
// Screen coordinates are pixels of the window's frame buffer from its upper left corner, y down;
// picture coordinates are pixels of the frame, (0, 0) its upper left corner, pixel (x, y) covering
// [x, x + 1) x [y, y + 1).
#pragma once

#include <optional>

#include "renderer/core/rect.h"
#include "renderer/core/vector.h"

namespace emberline {

class PicturePlacement {
 public:
  static constexpr double kLeastZoom = 1.0 / 32.0, kMostZoom = 32.0;

  // The part of the window that the picture may have, and the size of the frame. Keeps the zoom
  // and what is in the middle.
  void place(const Rect& area, int width, int height);

  // The whole picture, as large as it fits; from now on also when the area changes.
  void fit();
  bool fitted() const { return fitted_; }
  // `zoom` is clamped; what is under `screen` stays under it.
  void zoom_to(double zoom, const Vec2f& screen);
  void zoom_to(double zoom);  // about the middle of the area
  // Moves the picture with the mouse.
  void drag(const Vec2f& screen_delta);

  double zoom() const { return zoom_; }
  const Rect& area() const { return area_; }
  Vec2f to_screen(const Vec2f& picture) const;
  Vec2f to_picture(const Vec2f& screen) const;
  // The pixel under a point of the screen; none beside the picture or outside the area.
  std::optional<Vec2i> pixel_at(const Vec2f& screen) const;

 private:
  void fit_now();
  void keep_in_sight();

  Rect area_;
  int width_ = 0, height_ = 0;
  double zoom_ = 1.0;
  double left_ = 0.0, top_ = 0.0;  // of the picture, on the screen
  bool fitted_ = true;
};

}  // namespace emberline
