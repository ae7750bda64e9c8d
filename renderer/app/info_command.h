// `emberline info`: what is in a scene, which features it needs, what is approximated or ignored;
// or which channels pictures can have.
#pragma once

#include <string>

#include "renderer/engine/frame_settings.h"

#include "renderer/engine/run_limits.h"

namespace emberline {

struct InfoOptions {
  std::string scene;      // unless `channels`
  bool channels = false;  // the table of channels instead
  bool json = false;
  FrameSettings settings;  // how it is loaded
  LimitOptions limits;
};

// Prints to stdout. Returns the exit code. Throws EmberlineError.
int run_info(const InfoOptions& options);

}  // namespace emberline
