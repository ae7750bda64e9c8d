// `two-stream` and `nested` estimate the variance of a pixel's mean and pool it over the pixel's
// neighbours. The statistics hold the difference of two independent streams of the pixel's samples
// or, for `nested`, the difference of the two halves of one stream (sample_halves.h).
//
// The spread of the samples has as many degrees of freedom as there are samples, but assumes that
// the samples are independent. Stratified samples are not independent, so the spread may be
// thousands of times too large. The squared difference of the streams' means is right however
// correlated the samples are, but has only one degree of freedom. Spread and squared difference are
// both pooled over 5 x 5 pixels with a Gaussian of sigma 1.2 pixels. The pooled difference is the
// error estimate. The allocation uses the product of two values. The first is the spread: a blend
// of the pooled spread and the pixel's own spread, which has more weight the more samples the pixel
// has. The second is the effect of stratification: the ratio of the pooled difference to the pooled
// spread, plus a tenth, so that a pixel does not end because its streams agree by chance. If no
// nearby pixel has a second stream yet, the spread replaces the difference.
//
// Pooling reduces the influence of a pixel's own luck on its sample count, which keeps the bias of
// adaptive sampling low (Kirk & Arvo 1991, "Unbiased Sampling Techniques for Image Synthesis").
// Before pooling, each difference is weighted for display at the mean of its own pixel. The
// neighbours' mean would not do: it is clipped white beside a lamp and too dark beside a shadow.
#pragma once

#include "renderer/drivers/adaptive/error_estimator.h"

namespace emberline {

void estimate_two_stream(const PixelStatistics& pixels, const EstimatorSettings& settings,
                         ErrorMap* out);

}  // namespace emberline
