// Draws the picture and what lies over it: the other half of a wipe, buckets in progress, the
// region, values of enlarged pixels. None of it changes the pixels.
#pragma once

#include "renderer/window/picture/plain_shader.h"
#include "renderer/window/picture/texture.h"
#include "renderer/window/workbench/workbench.h"

namespace emberline {

class PictureView {
 public:
  // Call between ImGui's NewFrame and Render.
  void draw(Workbench& bench, const std::optional<Rect>& dragged_region);

  // The newest picture drawn; null before.
  const std::shared_ptr<const SessionPicture>& drawn() const { return drawn_; }

 private:
  void upload(const Workbench& bench);

  PictureTexture picture_, picture_b_;
  PlainShader plain_;
  std::shared_ptr<const SessionPicture> drawn_, drawn_b_;
  bool drawn_b_raw_ = false;
};

// Shows what is known of the pixel under the cursor, beside it.
void draw_inspector(const Workbench& bench);

}  // namespace emberline
