// A feature's noise at silhouettes, in defocus and in motion would be taken for the picture's own
// structure: each feature is filtered first, by its own noise (Bitterli et al. 2016, §4).
#pragma once

#include "renderer/reconstruction/halves.h"

namespace emberline {

// Non-local means of each half by the other half's weights, and the mean of both. `variance` is
// that of one sample. A row depends on those kFeatureReach around it.
inline constexpr int kFeatureReach = 4;
Feature filter_feature(const Halves& halves, const BorderedPlane& a, const BorderedPlane& b,
                       const BorderedPlane& variance);

}  // namespace emberline
