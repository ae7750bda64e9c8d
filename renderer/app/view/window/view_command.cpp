#include "renderer/app/view/window/view_command.h"

#include "renderer/app/view/window/window.h"
#include "renderer/core/errors.h"

namespace emberline {

int run_view(const ViewOptions& options) {
  Window window(options);
  window.run();
  return kExitDone;
}

}  // namespace emberline
