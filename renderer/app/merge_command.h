// emberline merge: the parts of a frame as one.
#pragma once

#include <string>
#include <vector>

#include "renderer/output/render_options.h"

namespace emberline {

struct MergeOptions {
  std::vector<std::string> parts;  // checkpoints that `emberline render` has kept
  bool allow_holes = false, strict = false;
  RenderOptions frame;  // outputs, reports, threads and limits; the rest is the parts'
};

// Writes what `render` would have written of the whole frame: the same bits of tiles, of sample
// ranges up to the rounding of other sums. Returns kExitDone, or kExitRenderFailed where a file
// could not be written. Throws UsageError, InputError (parts that do not go together) and
// RenderError.
int run_merge(const MergeOptions& options);

}  // namespace emberline
