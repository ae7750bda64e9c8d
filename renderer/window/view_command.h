// `emberline view SCENE`: the interactive window.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "renderer/output/render_options.h"

namespace emberline {

struct ViewOptions {
  // As `render` takes them, those that concern one file of results left out. The scene may be
  // absent: one is dropped onto the window, or opened from its menu.
  RenderOptions render;
  std::optional<float> interface_scale;  // of letters and panels; absent: the screen's
  std::optional<Vec2i> window_size;      // absent: as it was last time
  std::string screenshot;  // of the window, written when the picture is done; then it closes
  double screenshot_after_s =
      0.0;                     // 0: when the frame has ended; else so long after the scene is there
  std::string measure;         // latencies of the edits of a script; then it closes
  std::string measure_script;  // empty: the built-in one
  std::string journal;         // what the window does, a line of JSON each
  std::function<bool()> stopped = {};  // asked all the time: the window is to close; empty: never
  bool forget = false;                 // what it remembers is neither read nor written
};

// Opens the window and returns when it is closed: kExitDone. Throws RenderError where there is no
// display, no OpenGL, or no window library in this build; UsageError, InputError as `render` does
// for options.
int run_view(const ViewOptions& options);

}  // namespace emberline
