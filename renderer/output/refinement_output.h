// Writes the adaptive driver's refinement tree as an overlay, as JSON, and to files.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "io/files/write_attempts.h"
#include "renderer/engine/render_job.h"
#include "renderer/output/render_options.h"

namespace emberline {

class RefinementTree;

// Draws half-transparent borders of the tree's leaves over `rgba`. This is an interleaved RGBA
// picture with `width` pixels per row, which begins at the upper left corner of the crop. Does not
// change alpha. Leaves of a single pixel get no border, because their borders would cover the
// finished parts of the picture.
void draw_leaf_borders(const RefinementTree& tree, std::span<float> rgba, int width);

// Returns one JSON object:
//   window           [x0, y0, x1, y1], half-open, in pixels
//   phase, rounds    refinement_phase_name(), number of rounds added to the tree
//   samples, pixels  number of samples added to the tree, number of pixels
//   settings         the tree's settings
//   leaves_by_area   [n0, n1, ...]: nk is the number of leaves of 2^k .. 2^(k+1) - 1 pixels
//   open             number of leaves that can still be split
//   next             the first `max_leaves` of these leaves by priority:
//                    {rect, value, v_int, v_ext, priority}
std::string refinement_json(const RefinementTree& tree, size_t max_leaves = 1024);

// Writes one file for each path in options.trees.
void write_refinement(const RenderOptions& options, const RenderJob& rendered,
                      WriteAttempts& attempts);

}  // namespace emberline
