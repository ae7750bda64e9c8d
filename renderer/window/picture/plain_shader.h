// Draws a picture without ImGui's vertex colour and blending. A graphics card makes no difference,
// but llvmpipe, Mesa's software OpenGL, copies such a picture instead of shading it per pixel: 1.4
// ms instead of 5 ms per frame for a window of 1640 x 860.
#pragma once

#include <imgui.h>

namespace emberline {

// Use with its OpenGL context current. Its objects are freed with the context.
class PlainShader {
 public:
  // Images added to `list` between begin() and end() are drawn opaque, by their texture alone. If
  // the driver rejects the shader, ImGui's is used. The object must exist until the list is drawn.
  void begin(ImDrawList& list);
  static void end(ImDrawList& list);

 private:
  static void use(const ImDrawList* list, const ImDrawCmd* command);
  void build(unsigned imgui_program);

  bool built_ = false;
  unsigned program_ = 0;  // 0: rejected by the driver
  int projection_ = -1, projection_of_imgui_ = -1;
};

}  // namespace emberline
