// `two-stream` and `nested` estimate the variance of a pixel's mean and pool it over the pixel's
// neighbours. The statistics hold the difference of two independent streams of the pixel's samples
// or, for `nested`, the difference of the two halves of one stream (sample_halves.h).
//
// There are two ways to estimate the variance. The spread of the samples has about as many degrees
// of freedom as there are samples, but it assumes independent samples. For stratified samples it
// may be thousands of times too large. The squared difference of the streams' means is right
// however correlated the samples are, but it has only one degree of freedom. Both values are pooled
// over 5 x 5 pixels (pooling.h). If no nearby pixel has a second stream yet, the spread replaces
// the squared difference.
//
// The error estimate is computed from the pooled squared difference. The squared deviation, which
// the allocation uses, is the product of two values. The first is the spread: a blend of the pooled
// spread and the pixel's own spread. The more samples the pixel has, the more weight its own spread
// has. The second is the effect of stratification: the ratio of the pooled squared difference to
// the pooled spread, plus a tenth. The tenth keeps a pixel from ending because its streams agree by
// chance.
//
// Pooling reduces the influence of a pixel's own luck on its sample count, which keeps the bias of
// adaptive sampling low (Kirk & Arvo 1991, "Unbiased Sampling Techniques for Image Synthesis").
// Before pooling, each squared difference is weighted for display (display_error_weight()) at the
// mean of its own pixel. The neighbours' mean would be wrong: it is clipped white beside a lamp and
// too dark beside a shadow.
#pragma once

#include "renderer/drivers/adaptive/error_estimator.h"

namespace emberline {

void estimate_two_stream(const PixelStatistics& pixels, const EstimatorSettings& settings,
                         ErrorMap* out);

}  // namespace emberline
