// Interpolates the incomplete picture of a refinement tree between its samples.
#pragma once

#include <span>

#include "renderer/core/vector.h"
#include "renderer/drivers/adaptive/refinement_tree.h"

namespace emberline {

// Fills `picture` from the tree's samples. `values` must have one value for each leaf, and
// `picture` one for each pixel of the tree's crop, with rows from its top (asserted). A pixel with
// a sample gets exactly its value. The other pixels are filled by pull-push (Gortler, Grzeszczuk,
// Szeliski & Cohen 1996, "The Lumigraph", section 3.4.2). This builds a pyramid of 2 x 2 means of
// the known pixels, and fills the holes of each level bilinearly from the next coarser level.
// Constants are reproduced exactly. Before the first sample the picture is black. May be called
// from any thread while the tree does not change. Runs in the caller's TBB arena; the result is
// bit-identical in any arena.
void reconstruct_smooth(const RefinementTree& tree, std::span<const Rgb> values,
                        std::span<Rgb> picture);

}  // namespace emberline
