// The native window: GLFW, OpenGL and Dear ImGui around a Workbench, and the loop that wakes up
// when there is something to do. Their headers stay in window.cpp.
#pragma once

#include <memory>

#include "renderer/window/view_command.h"

namespace emberline {

class Window {
 public:
  // Throws RenderError where there is no display or no OpenGL 3.0.
  explicit Window(const ViewOptions& options);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  // Until it is closed, by its user or by what the options asked for.
  void run();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace emberline
