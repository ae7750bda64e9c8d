// `render --frames`: one frame after another, with one report of all.
#pragma once

#include <vector>

#include "renderer/output/render_options.h"

namespace emberline {

// Goes on behind a frame that fails, unless --stop-on-error says otherwise. Returns the highest of
// the frames' exit codes. Throws EmberlineError for what is wrong with all of them: the command
// line, or the scene.
int run_range(const RenderOptions& options, const std::vector<int>& frames);

}  // namespace emberline
