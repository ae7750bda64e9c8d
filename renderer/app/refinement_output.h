// The adaptive driver's refinement tree as files.
#pragma once

#include <string>

#include "renderer/app/render_options.h"
#include "renderer/app/write_attempts.h"
#include "renderer/drivers/frame_plan.h"
#include "renderer/drivers/frame_render.h"

namespace emberline {

// Throws UsageError for what --explain and --tree cannot do: another driver, a pixel outside the
// window, an unknown suffix.
void check_refinement_options(const RenderOptions& options, const FramePlan& plan);

// Writes each of options.trees.
void write_refinement(const RenderOptions& options, const FrameRender& rendered,
                      WriteAttempts& attempts);

}  // namespace emberline
