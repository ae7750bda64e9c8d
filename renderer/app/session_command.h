// `emberline session`: the window's session for another program, over standard input and output
// (renderer/session/PROTOCOL.md).
#pragma once

#include <optional>

#include <string>

#include "renderer/core/rect.h"
#include "renderer/output/render_options.h"

namespace emberline {

// What both the command line and the host may say.
struct SessionOptions {
  SessionOptions() { render.driver = kLiveDriver; }

  RenderOptions render;  // scene and results mean nothing
  std::string overlay = "none", format = "linear";
  std::optional<Rect> region;
  bool paused = false, denoise = false;
};

// Returns kExitDone when the host says "quit". Throws as run_session_host() does, and UsageError.
int run_session(const SessionOptions& options);

}  // namespace emberline
