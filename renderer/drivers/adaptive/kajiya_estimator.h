// `kajiya`: after Kajiya 1986, "The Rendering Equation", Computer Graphics 20(4) (SIGGRAPH 86),
// hierarchical sampling.
//
// The paper keeps a tree over the sample domain and reads a node's variance off the difference of
// its two halves. A pixel's two independent sample streams stand for the halves of its root: the
// difference of their means, squared, times n_A n_B / n^2, is the variance of the mean of all n,
// whatever the samples of a stream owe to each other. The error is its root in display units, root
// of the mean over the channels.
//
// Fault, kept: the estimate is right on average and has one degree of freedom. 38 % of the pixels
// are judged at less than half of their true error and 8 % at less than a tenth, so any threshold
// finishes some pixels that are far from it, and those too where neither stream met the rare light.
// Measured in tests/unit/drivers/adaptive/error_estimator_statistics_test.cpp.
#pragma once

#include "renderer/drivers/adaptive/error_estimator.h"

namespace emberline {

// Variance of the mean of all samples, from the difference of the means of two independent streams
// of `first` and `second` samples, 1 or more each.
float half_difference_variance(float difference, float first, float second);

// Ours, whole blocks of both streams: the paper, as far as we know it, has none.
inline constexpr uint32_t kKajiyaBatch = 16;

void estimate_kajiya(const PixelStatistics& pixels, const EstimatorSettings& settings,
                     ErrorMap* out);

}  // namespace emberline
