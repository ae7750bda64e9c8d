// Draws a picture as it is: without the colour that ImGui's own shader multiplies with, and without
// blending. A graphics card does not feel the difference; llvmpipe, Mesa's OpenGL in software,
// copies such a picture where it shades any other pixel by pixel: of a window of 1640 x 860,
// a processor's 1.4 ms a frame instead of 5.
#pragma once

#include <imgui.h>

namespace emberline {

// To be used with its OpenGL context current, whose objects it leaves to the context's end.
class PlainShader {
 public:
  // Between these two, images added to `list` are drawn plainly, by their texture alone: opaque,
  // whatever alpha they have. Where a driver will not have the shader, ImGui's draws them. The
  // object must be there until the list is drawn.
  void begin(ImDrawList& list);
  static void end(ImDrawList& list);

 private:
  static void use(const ImDrawList* list, const ImDrawCmd* command);
  void build(unsigned like);

  bool built_ = false;
  unsigned program_ = 0;  // 0: the driver will not have it
  int projection_ = -1, projection_of_imgui_ = -1;
};

}  // namespace emberline
