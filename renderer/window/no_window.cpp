// Stub that is built instead of the window if the window libraries were not found.
#include "renderer/core/errors.h"
#include "renderer/window/view_command.h"

namespace emberline {

int run_view(const ViewOptions& /*options*/) {
  throw RenderError(
      "this build of emberline has no window, because it was made without GLFW and Dear ImGui; "
      "install libglfw3-dev and libimgui-dev and build again, or use `emberline render`");
}

}  // namespace emberline
