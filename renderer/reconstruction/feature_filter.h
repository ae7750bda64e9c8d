// Filters each feature according to its own noise before it is used. Otherwise the regression would
// mistake a feature's noise at silhouettes, in defocus and in motion for image structure (Bitterli
// et al. 2016, §4).
#pragma once

#include "renderer/reconstruction/halves.h"

namespace emberline {

// Filters each half by non-local means with the other half's weights, and returns the mean of the
// two filtered halves. `variance` is the variance of one sample. A row depends on rows up to
// kFeatureReach away.
inline constexpr int kFeatureReach = 4;
Feature filter_feature(const Halves& halves, const BorderedPlane& a, const BorderedPlane& b,
                       const BorderedPlane& variance);

}  // namespace emberline
