// `kajiya`: after the hierarchical sampling of Kajiya 1986, "The Rendering Equation", Computer
// Graphics 20(4) (SIGGRAPH 86).
//
// The paper keeps a tree over the sample domain and estimates a node's variance from the difference
// of its two halves. Here each pixel has only the root of that tree, and the pixel's two
// independent sample streams are the root's halves. The squared difference of the streams' means,
// times n_A n_B / n^2, estimates the variance of the mean of all n samples, however correlated the
// samples within a stream are. The error is the square root of that variance in display units, as
// the root mean square over the channels.
//
// Known fault of the method: the estimate is right on average but has only one degree of freedom.
// The estimate is less than half of the true error for 38 % of the pixels and less than a tenth for
// 8 %. So with any threshold, some pixels finish although their errors are far larger, including
// pixels where neither stream found rare light. These fractions are measured in
// tests/unit/drivers/adaptive/error_estimator_statistics_test.cpp.
#pragma once

#include "renderer/drivers/adaptive/error_estimator.h"

namespace emberline {

// Returns the variance of the mean of all samples, computed from the difference of the means of two
// independent streams. The streams have `first` and `second` samples, each at least 1.
float half_difference_variance(float difference, float first, float second);

// Our choice: one block of 8 samples of each stream. As far as we know, the paper gives no number.
inline constexpr uint32_t kKajiyaBatch = 16;

void estimate_kajiya(const PixelStatistics& pixels, const EstimatorSettings& settings,
                     ErrorMap* out);

}  // namespace emberline
