// Draws a picture without ImGui's vertex colour and blending. To a graphics card that makes no
// difference, but llvmpipe, Mesa's software OpenGL, copies such a picture instead of shading each
// pixel: 1.4 ms instead of 5 ms per frame for a window of 1640 x 860.
#pragma once

#include <imgui.h>

namespace emberline {

// The window's OpenGL context must be current. The OpenGL objects are freed with the context.
class PlainShader {
 public:
  // Images added to `list` between begin() and end() are drawn opaque, with the colours of their
  // texture. If the driver rejects the shader, ImGui's is used. This object must exist until the
  // list is drawn.
  void begin(ImDrawList& list);
  static void end(ImDrawList& list);

 private:
  static void use(const ImDrawList* list, const ImDrawCmd* command);
  void build(unsigned imgui_program);

  bool built_ = false;
  unsigned program_ = 0;  // 0 after build() if the driver has rejected it
  int projection_ = -1, projection_of_imgui_ = -1;
};

}  // namespace emberline
