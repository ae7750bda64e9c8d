// The picture in the window, with what lies over it: the other half of a wipe, buckets under way,
// the region, the values of pixels when they are large. None of it is ever in the pixels.
#pragma once

#include "renderer/window/picture/plain_shader.h"
#include "renderer/window/picture/texture.h"
#include "renderer/window/workbench/workbench.h"

namespace emberline {

class PictureView {
 public:
  // Between ImGui's NewFrame and Render.
  void draw(Workbench& bench, const std::optional<Rect>& dragged_region);

  // The newest picture that draw() has drawn; null before.
  const std::shared_ptr<const ShownPicture>& drawn() const { return drawn_; }

 private:
  void upload(const Workbench& bench);

  PictureTexture picture_, picture_b_;
  PlainShader plain_;
  std::shared_ptr<const ShownPicture> drawn_, drawn_b_;
  bool drawn_b_raw_ = false;
};

// Beside the cursor: what is known of the pixel under it.
void draw_inspector(const Workbench& bench);

}  // namespace emberline
