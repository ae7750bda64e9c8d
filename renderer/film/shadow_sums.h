// The light that shadow catchers receive: with the whole scene, and with the plate's objects only.
#pragma once

#include <cstdint>

namespace emberline {

struct FilmSample;

// Sums of a pixel, in the order of CatcherSample: received R G B, unshadowed R G B, catcher,
// hidden, background.
inline constexpr uint32_t kShadowSums = 9;
void add_shadow(const FilmSample& sample, double* sums);

// Writes the R G B factor for the plate, in [0, 1]: received over unshadowed light on catchers, 1
// elsewhere.
void put_shadow(const double* sums, float* rgb);
// Returns how much of the pixel's samples put_shadow() is about: those that see a catcher or
// nothing.
double shadow_weight(const double* sums);
// Returns the alpha of the shadows on hidden catchers, summed over the pixel's samples.
double shadow_alpha(const double* sums);

}  // namespace emberline
