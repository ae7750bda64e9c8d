// What a refinement tree looks like: the incomplete picture, smooth between the samples, its leaves
// drawn over a picture, its state as JSON.
//
// Pictures are of the tree's crop, rows from its top, linear Rec. 709. All of them may be made
// from any thread while the tree is not changed; the work is shared out on the caller's TBB arena,
// and the bits do not depend on it.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "renderer/core/vector.h"
#include "renderer/drivers/adaptive/refinement_tree.h"

namespace emberline {

// Of a value for each leaf: smooth between the samples, and equal to the sample where a pixel has
// one, so that it becomes the picture itself in the end. Pull-push (Gortler, Grzeszczuk, Szeliski &
// Cohen 1996, "The Lumigraph", section 3.4.2): a pyramid of 2 x 2 means of the pixels known, whose
// holes are filled from the next coarser level, bilinearly. A constant comes out exactly. `picture`
// holds the crop's pixels (asserted). Black before the first sample.
void reconstruct_smooth(const RefinementTree& tree, std::span<const Rgb> values,
                        std::span<Rgb> picture);

// Draws the borders of the leaves, half transparent, over a picture of the crop: interleaved
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

}  // namespace emberline
