// The adaptive driver's refinement tree, drawn over a picture, as JSON, and as files.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "io/files/write_attempts.h"
#include "renderer/engine/render_job.h"
#include "renderer/output/render_options.h"

namespace emberline {

class RefinementTree;

// Draws the borders of the leaves, half transparent, over a picture of the tree's crop: interleaved
// RGBA, `width` pixels a row, its first pixel the crop's corner; alpha stays. Leaves of a single
// pixel get no border: it would hide the picture where it is complete.
void draw_leaf_borders(const RefinementTree& tree, std::span<float> rgba, int width);

// One JSON object:
//   window           [x0, y0, x1, y1], half-open, in pixels
//   phase, rounds    refinement_phase_name(), rounds inserted
//   samples, pixels  inserted, and in all
//   settings         those of the tree
//   leaves_by_area   [n0, n1, ...]: leaves of 2^k .. 2^(k+1) - 1 pixels
//   open             leaves that can still be split
//   next             the first `most_leaves` of them by priority:
//                    {rect, value, v_int, v_ext, priority}
std::string refinement_json(const RefinementTree& tree, size_t most_leaves = 1024);

// Writes each of options.trees.
void write_refinement(const RenderOptions& options, const RenderJob& rendered,
                      WriteAttempts& attempts);

}  // namespace emberline
