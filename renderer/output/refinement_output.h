// The adaptive driver's refinement tree as files.
#pragma once

#include <string>

#include "io/files/write_attempts.h"
#include "renderer/engine/frame_plan.h"
#include "renderer/engine/render_job.h"
#include "renderer/output/render_options.h"

namespace emberline {

// Throws UsageError for what --explain and --tree cannot do: another driver, a pixel outside the
// crop, an unknown suffix.
void check_refinement_options(const RenderOptions& options, const FramePlan& plan);

// Writes each of options.trees.
void write_refinement(const RenderOptions& options, const RenderJob& rendered,
                      WriteAttempts& attempts);

}  // namespace emberline
