// RAII owners of GLFW, a window, and Dear ImGui's context. Create them in this order, on the
// window's thread.
#pragma once

#include <memory>

#include "renderer/window/view_command.h"
#include "renderer/window/window_state.h"

struct GLFWwindow;

namespace emberline {

struct Glfw {
  // Throws RenderError if there is no display.
  Glfw();
  ~Glfw();
  Glfw(const Glfw&) = delete;
  Glfw& operator=(const Glfw&) = delete;
};

struct DestroyWindow {
  void operator()(GLFWwindow* window) const;
};
using WindowHandle = std::unique_ptr<GLFWwindow, DestroyWindow>;

// Opens a window and makes its OpenGL 3.0 context current. The remembered size is multiplied by
// `scale`. Throws RenderError.
WindowHandle open_window(const ViewOptions& options, const WindowState& state, float scale);

// ImGui's context and its two back ends.
struct ImGuiContextOwner {
  explicit ImGuiContextOwner(GLFWwindow* window);
  ~ImGuiContextOwner();
  ImGuiContextOwner(const ImGuiContextOwner&) = delete;
  ImGuiContextOwner& operator=(const ImGuiContextOwner&) = delete;
};

// Returns the screen's scale for text, which is 1 on an ordinary screen.
float screen_scale();

}  // namespace emberline
