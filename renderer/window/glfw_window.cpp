#include "renderer/window/glfw_window.h"

#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <algorithm>
#include <cstdlib>
#include <string>

#include "renderer/core/errors.h"

namespace emberline {
namespace {

std::string last_glfw_error = "no display";

RenderError no_window() {
  return RenderError("cannot open a window: " + last_glfw_error +
                     "; `emberline render` needs no display");
}

}  // namespace

Glfw::Glfw() {
  glfwSetErrorCallback([](int, const char* description) { last_glfw_error = description; });
#if defined(GLFW_PLATFORM_X11) && defined(__linux__)
  // GLFW 3.4 and later try Wayland first, and the Wayland library prints an error if no Wayland
  // server runs.
  if (!std::getenv("WAYLAND_DISPLAY") && !std::getenv("WAYLAND_SOCKET")) {
    glfwInitHint(GLFW_PLATFORM, GLFW_PLATFORM_X11);
  }
#endif
  if (!glfwInit()) throw no_window();
}

Glfw::~Glfw() { glfwTerminate(); }

void DestroyWindow::operator()(GLFWwindow* window) const { glfwDestroyWindow(window); }

WindowHandle open_window(const ViewOptions& options, const WindowState& state, float scale) {
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 0);
  // The interface needs no depth or stencil buffer, and an opaque window needs no alpha.
  for (const int bits : {GLFW_DEPTH_BITS, GLFW_STENCIL_BITS, GLFW_ALPHA_BITS}) {
    glfwWindowHint(bits, 0);
  }
  glfwWindowHint(GLFW_MAXIMIZED, state.maximized && !options.window_size);
  glfwWindowHintString(GLFW_X11_CLASS_NAME, "emberline");
  glfwWindowHintString(GLFW_X11_INSTANCE_NAME, "emberline");
  // The remembered size may come from a larger screen.
  int unused = 0, max_x = 0, max_y = 0;
  if (GLFWmonitor* const screen = glfwGetPrimaryMonitor()) {
    glfwGetMonitorWorkarea(screen, &unused, &unused, &max_x, &max_y);
  }
  const auto scale_to_screen = [&](int size, int limit) {
    const int scaled = int(float(size) * scale);
    return limit > 0 ? std::min(scaled, limit) : scaled;
  };
  const int width =
      options.window_size ? options.window_size->x : scale_to_screen(state.width, max_x);
  const int height =
      options.window_size ? options.window_size->y : scale_to_screen(state.height, max_y);
  WindowHandle window(glfwCreateWindow(width, height, "Emberline", nullptr, nullptr));
  if (!window) throw no_window();
  glfwMakeContextCurrent(window.get());
  // Waiting for vertical sync would block this thread. The event loop limits the redraw rate
  // itself.
  glfwSwapInterval(0);
  return window;
}

ImGuiContextOwner::ImGuiContextOwner(GLFWwindow* window) {
  IMGUI_CHECKVERSION();
  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr;  // window_state.h stores the window's state
  ImGui_ImplGlfw_InitForOpenGL(window, true);
  ImGui_ImplOpenGL3_Init("#version 130");
}

ImGuiContextOwner::~ImGuiContextOwner() {
  ImGui_ImplOpenGL3_Shutdown();
  ImGui_ImplGlfw_Shutdown();
  ImGui::DestroyContext();
}

float screen_scale() {
  float x = 1.0f, y = 1.0f;
  if (GLFWmonitor* monitor = glfwGetPrimaryMonitor()) glfwGetMonitorContentScale(monitor, &x, &y);
  return std::max(x, y);
}

}  // namespace emberline
