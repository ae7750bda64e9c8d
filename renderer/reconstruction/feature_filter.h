// Filters each feature by its own noise first. Otherwise a feature's noise at silhouettes, in
// defocus and in motion would be taken for structure of the image (Bitterli et al. 2016, §4).
#pragma once

#include "renderer/reconstruction/halves.h"

namespace emberline {

// Non-local means of each half with the other half's weights, and the mean of both. `variance` is
// that of one sample. A row depends on those up to kFeatureReach around it.
inline constexpr int kFeatureReach = 4;
Feature filter_feature(const Halves& halves, const BorderedPlane& a, const BorderedPlane& b,
                       const BorderedPlane& variance);

}  // namespace emberline
