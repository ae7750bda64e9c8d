// `emberline view SCENE`: the interactive window.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "renderer/output/render_options.h"

namespace emberline {

struct ViewOptions {
  // Options of `render`, except those for output files. The scene may be empty: the user can drop
  // one onto the window or open one from the menu.
  RenderOptions render;
  std::optional<float> interface_scale;  // scale of text and panels; if absent, the screen's scale
  std::optional<Vec2i> window_size;      // if absent, the remembered size
  std::string screenshot;  // output file for a screenshot; the window closes when it is written
  double screenshot_after_s = 0.0;  // seconds after the first complete picture; if 0, when the
                                    // frame is finished
  std::string measure;  // output file for edit latencies; the window closes when they are measured
  std::string measure_script;          // if empty, the built-in script
  std::string journal;                 // output file for the journal, in JSON lines
  std::function<bool()> stopped = {};  // polled; returns whether to close the window; may be empty
  bool forget = false;                 // do not read or write the remembered state
};

// Opens the window and returns kExitDone when it is closed. Throws RenderError if there is no
// display or no OpenGL, or if this build has no window library. Throws UsageError and InputError
// for options, as `render` does.
int run_view(const ViewOptions& options);

}  // namespace emberline
