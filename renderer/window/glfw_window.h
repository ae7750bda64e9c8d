// Owners of what the window's libraries have: GLFW itself, a window, Dear ImGui's context. To be
// made in this order, on the window's thread.
#pragma once

#include <memory>

#include "renderer/window/view_command.h"
#include "renderer/window/window_state.h"

struct GLFWwindow;

namespace emberline {

struct Glfw {
  // Throws RenderError where there is no display.
  Glfw();
  ~Glfw();
  Glfw(const Glfw&) = delete;
  Glfw& operator=(const Glfw&) = delete;
};

struct DestroyWindow {
  void operator()(GLFWwindow* window) const;
};
using WindowHandle = std::unique_ptr<GLFWwindow, DestroyWindow>;

// A window with a current OpenGL 3.0 context. `scale`: of what is remembered of its size. Throws
// RenderError.
WindowHandle open_window(const ViewOptions& options, const WindowState& state, float scale);

// ImGui's context and its two back ends.
struct ImGuiContextOwner {
  explicit ImGuiContextOwner(GLFWwindow* window);
  ~ImGuiContextOwner();
  ImGuiContextOwner(const ImGuiContextOwner&) = delete;
  ImGuiContextOwner& operator=(const ImGuiContextOwner&) = delete;
};

// How much larger than on an ordinary screen letters are to be.
float screen_scale();

}  // namespace emberline
