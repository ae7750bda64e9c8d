// Whether a frame need not be rendered again: --skip-existing.
#pragma once

#include "renderer/output/render_options.h"

namespace emberline {

// All pictures, heatmaps, trees and reports of the options are there. Files appear whole, so what
// is there is whole, unless it says that it is of a frame that was stopped (picture_mark.h; of a
// JSON report "complete"), cannot be read, or a checkpoint waits to go on with. How the frame was
// rendered, nobody asks.
bool is_finished(const RenderOptions& options);

}  // namespace emberline
