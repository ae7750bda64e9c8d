// --skip-existing: whether a frame is already finished.
#pragma once

#include "renderer/output/render_options.h"

namespace emberline {

// True if all pictures, heatmaps, trees and reports of the options exist, are not truncated
// (file_completeness.h) and are not from a stopped frame (JSON reports: "complete"). Existing
// snapshots must be intact, and no checkpoint may be waiting to be resumed. Settings are not
// compared.
bool is_finished(const RenderOptions& options);

}  // namespace emberline
