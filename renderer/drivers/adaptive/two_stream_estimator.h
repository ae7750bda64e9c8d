// `two-stream` and `nested`: the variance of a pixel's mean, pooled over the pixel's neighbours.
// The statistics hold the difference of two independent streams of the pixel's samples, or, of
// `nested`, that of the two halves of one (sample_halves.h).
//
// The samples' own spread has as many degrees of freedom as samples, but takes them for
// independent, which stratified ones are not: it may be thousands of times too large. The squared
// difference of the streams' means is right whatever the samples owe to each other, but has one
// degree of freedom. Both are pooled over 5 x 5 pixels, Gaussian, sigma 1.2 pixels. The second is
// the error estimate. The allocation goes by the spread, the pixel's own weighing more the more
// samples it has, times what stratification makes of it: the ratio of the second to the first among
// the neighbours, with a tenth of the first added, so that streams that happen to agree do not end
// a pixel. Where no pixel nearby has a second stream yet, the first stands in.
//
// Pooling means that a pixel's own luck decides little about its own samples, which keeps the bias
// of adaptive sampling low (Kirk & Arvo 1991, "Unbiased Sampling Techniques for Image Synthesis").
// How much of its difference the display shows, each pixel says before they are pooled: beside a
// lamp the neighbours' mean is clipped white, beside a shadow it is too dark.
//
// What no sample of a pixel has met no spread of them tells: where lamps are small and bright, most
// pixels look dark and sure, and are wrong. ErrorMap::missed says how wrong, by what their
// neighbours have met: for the report, not for the allocation.
#pragma once

#include "renderer/drivers/adaptive/error_estimator.h"

namespace emberline {

void estimate_two_stream(const PixelStatistics& pixels, const EstimatorSettings& settings,
                         ErrorMap* out);

}  // namespace emberline
