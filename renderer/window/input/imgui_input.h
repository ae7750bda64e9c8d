// Passes keys to Dear ImGui so that no key is lost. ImGui before version 1.87 polls keys once per
// frame and would miss a key that is pressed and released between two frames. Later versions queue
// events and may need several frames to handle them.
#pragma once

#include <vector>

struct GLFWwindow;

namespace emberline {

class ImGuiInput {
 public:
  // Call from GLFW's key callback, with its arguments.
  void key(GLFWwindow* window, int key, int scancode, int action, int modifiers);
  // Call after each frame. Returns whether some input is left for the next frame.
  bool end_frame();

 private:
  struct KeyEvent {
    GLFWwindow* window;
    int key, scancode, action, modifiers;
  };
  std::vector<int> pressed_;             // keys pressed since the last frame
  std::vector<KeyEvent> late_releases_;  // releases of keys in pressed_, sent after the frame
};

}  // namespace emberline
