#include "renderer/window/input/imgui_input.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <imgui_internal.h>

#include <algorithm>
#include <utility>

namespace emberline {
namespace {

// Returns whether ImGui's event queue is empty. Also compiles for versions of ImGui without a
// queue, and then returns true.
template <typename Context>
bool queue_empty(const Context& context) {
  if constexpr (requires { context.InputEventsQueue; }) return context.InputEventsQueue.empty();
  return true;
}

}  // namespace

// If a key is pressed and released in the same frame, delays the release until the next frame.
void ImGuiInput::key(GLFWwindow* window, int key, int scancode, int action, int modifiers) {
  if (action == GLFW_RELEASE && std::ranges::find(pressed_, key) != pressed_.end()) {
    late_releases_.push_back({window, key, scancode, action, modifiers});
    return;
  }
  if (action == GLFW_PRESS) pressed_.push_back(key);
  ImGui_ImplGlfw_KeyCallback(window, key, scancode, action, modifiers);
}

bool ImGuiInput::end_frame() {
  pressed_.clear();
  const std::vector<KeyEvent> late = std::exchange(late_releases_, {});
  for (const KeyEvent& e : late) key(e.window, e.key, e.scancode, e.action, e.modifiers);
  return !late.empty() || !queue_empty(*ImGui::GetCurrentContext());
}

}  // namespace emberline
