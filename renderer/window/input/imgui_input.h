// Hands keys on to Dear ImGui, whose versions take input in two ways. Before 1.87 it looks at the
// keys once a frame, and misses one that is pressed and let go in between; since then it queues
// events, and spreads over several frames what one would lose.
#pragma once

#include <vector>

struct GLFWwindow;

namespace emberline {

class ImGuiInput {
 public:
  // From GLFW's callback, whose arguments these are.
  void key(GLFWwindow* window, int key, int scancode, int action, int modifiers);
  // After each frame. Whether there is input for the next one already.
  bool end_frame();

 private:
  struct KeyEvent {
    GLFWwindow* window;
    int key, scancode, action, modifiers;
  };
  std::vector<int> pressed_;             // since the last frame
  std::vector<KeyEvent> late_releases_;  // of those
};

}  // namespace emberline
