// The incomplete picture of a refinement tree, smooth between the samples.
#pragma once

#include <span>

#include "renderer/core/vector.h"
#include "renderer/drivers/adaptive/refinement_tree.h"

namespace emberline {

// `values`: one for each leaf. `picture`: the pixels of the tree's crop, rows from its top
// (asserted). A pixel with a sample gets exactly that. The others are filled by pull-push
// (Gortler, Grzeszczuk, Szeliski & Cohen 1996, "The Lumigraph", section 3.4.2): a pyramid of 2 x 2
// means of the known pixels, whose holes are filled from the next coarser level, bilinearly. A
// constant comes out exactly. Black before the first sample. May be called from any thread while
// the tree is not changed; runs on the caller's TBB arena, and the bits do not depend on it.
void reconstruct_smooth(const RefinementTree& tree, std::span<const Rgb> values,
                        std::span<Rgb> picture);

}  // namespace emberline
