// Draws the picture and its overlays: the second picture of a wipe, buckets in progress, the
// region, and values of enlarged pixels. No overlay changes the picture's pixels.
#pragma once

#include "renderer/window/picture/plain_shader.h"
#include "renderer/window/picture/texture.h"
#include "renderer/window/workbench/workbench.h"

namespace emberline {

class PictureView {
 public:
  // Call between ImGui's NewFrame and Render.
  void draw(Workbench& bench, const std::optional<Rect>& dragged_region);

  // Returns the picture that was drawn last, or null before the first picture.
  const std::shared_ptr<const SessionPicture>& drawn() const { return drawn_; }

 private:
  void upload(const Workbench& bench);

  PictureTexture picture_, picture_b_;
  PlainShader plain_;
  std::shared_ptr<const SessionPicture> drawn_, drawn_b_;
  bool drawn_b_raw_ = false;
};

// Shows the values of the pixel under the cursor, in a box beside the pixel.
void draw_inspector(const Workbench& bench);

}  // namespace emberline
