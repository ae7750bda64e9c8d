// `emberline render`: a scene file becomes pictures and a report.
#pragma once

#include "renderer/output/render_options.h"

namespace emberline {

// Returns the exit code. Throws EmberlineError.
int run_render(const RenderOptions& options);

}  // namespace emberline
