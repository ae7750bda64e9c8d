// Passes keys to Dear ImGui, whose versions handle input differently. Before 1.87 it polls keys
// once per frame and misses a press and release in between; later versions queue events and spread
// them over several frames.
#pragma once

#include <vector>

struct GLFWwindow;

namespace emberline {

class ImGuiInput {
 public:
  // Call from GLFW's key callback, with its arguments.
  void key(GLFWwindow* window, int key, int scancode, int action, int modifiers);
  // Call after each frame. Returns whether there is already input for the next one.
  bool end_frame();

 private:
  struct KeyEvent {
    GLFWwindow* window;
    int key, scancode, action, modifiers;
  };
  std::vector<int> pressed_;             // since the last frame
  std::vector<KeyEvent> late_releases_;  // releases of pressed_ keys
};

}  // namespace emberline
