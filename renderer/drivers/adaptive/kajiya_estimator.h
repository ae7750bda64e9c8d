// `kajiya`: after Kajiya 1986, "The Rendering Equation", Computer Graphics 20(4) (SIGGRAPH 86),
// hierarchical sampling.
//
// The paper keeps a tree over the sample domain and estimates a node's variance from the difference
// of its two halves. Here a pixel's two independent sample streams are the halves of its root: the
// squared difference of their means, times n_A n_B / n^2, is the variance of the mean of all n,
// however correlated the samples within a stream are. The error is its square root in display
// units, root mean square over the channels.
//
// Known fault of the method: the estimate is right on average but has one degree of freedom. 38 %
// of the pixels are estimated at less than half of their true error and 8 % at less than a tenth,
// so any threshold finishes some pixels that are far from it, including those where neither stream
// found rare light. Measured in tests/unit/drivers/adaptive/error_estimator_statistics_test.cpp.
#pragma once

#include "renderer/drivers/adaptive/error_estimator.h"

namespace emberline {

// Variance of the mean of all samples, from the difference of the means of two independent streams
// with `first` and `second` samples, 1 or more each.
float half_difference_variance(float difference, float first, float second);

// Our choice, whole blocks of both streams; as far as we know, the paper gives none.
inline constexpr uint32_t kKajiyaBatch = 16;

void estimate_kajiya(const PixelStatistics& pixels, const EstimatorSettings& settings,
                     ErrorMap* out);

}  // namespace emberline
