// Whether a frame need not be rendered again: --skip-existing.
#pragma once

#include "renderer/output/render_options.h"

namespace emberline {

// All pictures, heatmaps, trees and reports of the options are there and whole: none was cut short
// (picture_mark.h), and none says that its frame was stopped (of a JSON report
// "complete"). Snapshots that are there are whole, and no checkpoint waits to go on with. The
// settings are not compared.
bool is_finished(const RenderOptions& options);

}  // namespace emberline
