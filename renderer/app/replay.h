// `--replay X,Y,SAMPLE`: one sample of the frame alone, exactly as the render computed it.
#pragma once

#include <string>

#include "renderer/engine/render_job.h"

namespace emberline {

// Prints the sample's ray and value to stdout. Throws UsageError for a malformed or outside
// address. Returns kExitDone, or kExitRenderFailed if the value is not finite.
int run_replay(const RenderJob& job, const std::string& address);

}  // namespace emberline
