// emberline extend: a finished frame to more samples, or a lower threshold.
#pragma once

#include <string>

#include "renderer/output/render_options.h"

namespace emberline {

struct ExtendOptions {
  std::string frame;   // a picture that was rendered with --resumable, or its checkpoint
  std::string scene;   // where its scene is now; empty: where it was
  RenderOptions more;  // samples, threshold, outputs, threads and limits; the rest is the frame's
};

// Renders what is missing, and replaces picture and checkpoint. Returns and throws what
// run_render() does; InputError for a frame that cannot go on.
int run_extend(const ExtendOptions& options);

}  // namespace emberline
