// Estimates the error from light that a pixel's samples have missed.
//
// Such light does not show in the samples' spread. With small, bright lamps, most pixels therefore
// look dark and reliable, but are wrong. Their neighbours tell what they have missed, except
// neighbours on the other side of an edge. So a pixel is compared only with those neighbours whose
// means could be equal to its own: in each channel the means must differ by at most 2.5 standard
// errors of the difference (Welch 1947, "The Generalization of 'Student's' Problem when Several
// Different Population Variances are Involved"; Sakai et al. 2024, "A Statistical Approach to Monte
// Carlo Denoising"). A neighbour that found rare light by a single sample has a large standard
// error, so it passes.
#pragma once

#include "renderer/drivers/adaptive/pixel_statistics.h"

namespace emberline {

// Returns the squared display error that is expected from missed light, summed over pixels and
// channels. The caller adds it to the error that the samples themselves show. The result is finite,
// not negative, and the same for any number of threads.
double missed_light_error(const PixelStatistics& pixels);

}  // namespace emberline
