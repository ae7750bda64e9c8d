// The light that shadow catchers receive from the whole scene, and the light that they would
// receive if only catchers and holdouts blocked light.
#pragma once

#include <cstdint>

namespace emberline {

struct FilmSample;

// Sums of a pixel, in the order of CatcherSample: received R G B, unshadowed R G B, catcher,
// hidden, background.
inline constexpr uint32_t kShadowSums = 9;
void add_shadow(const FilmSample& sample, double* sums);

// Writes the R G B factor for the plate, in [0, 1]. On catchers, it is the received light divided
// by the unshadowed light; elsewhere, it is 1.
void put_shadow(const double* sums, float* rgb);
// Returns the sum of the weights of the samples that see a catcher or the background. Only these
// samples determine the factor of put_shadow().
double shadow_weight(const double* sums);
// Returns the alpha of the shadows on hidden catchers, summed over the pixel's samples.
double shadow_alpha(const double* sums);

}  // namespace emberline
