// emberline heatmap: a picture of one of a rendered frame's own numbers.
#pragma once

#include <string>

#include "renderer/engine/run_limits.h"
#include "renderer/statistics/heatmap_quantity.h"

namespace emberline {

struct HeatmapOptions {
  std::string image;  // an .exr that `emberline render` wrote
  std::string output;
  std::string quantity;  // one of heatmap_quantity_table()
  HeatmapStyle style;
  LimitOptions limits;
};

// Writes what `render --heatmap` would have written for the frame: the same pixels.
// Returns kExitDone. Throws UsageError (names, style, suffix, output and input one file),
// InputError (unreadable, channels missing), RenderError (cannot write).
int run_heatmap(const HeatmapOptions& options);

}  // namespace emberline
