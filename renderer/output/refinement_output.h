// The adaptive driver's refinement tree as files.
#pragma once


#include "io/files/write_attempts.h"
#include "renderer/engine/render_job.h"
#include "renderer/output/render_options.h"

namespace emberline {

// Writes each of options.trees.
void write_refinement(const RenderOptions& options, const RenderJob& rendered,
                      WriteAttempts& attempts);

}  // namespace emberline
