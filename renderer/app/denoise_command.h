// emberline denoise: a finished frame's clean picture.
#pragma once

#include <string>
#include <vector>

#include "io/display/display.h"
#include "renderer/engine/run_limits.h"

namespace emberline {

struct DenoiseOptions {
  std::string image;                 // an .exr with the channels of `--aov denoising`
  std::vector<std::string> outputs;  // .exr: its channels and the results; .png, .jpg: the picture
  DisplaySettings display;           // of .png and .jpg
  int threads = 0;                   // 0: all
  LimitOptions limits;
};

// Gives what `render --denoise` of the same frame would have given, to the bit. Memory does not
// grow with the frame but by its width; of .png and .jpg with the picture. Returns the exit code.
// Throws InputError (unreadable, channels missing), UsageError (names), RenderError (cannot write
// it).
int run_denoise(const DenoiseOptions& options);

}  // namespace emberline
