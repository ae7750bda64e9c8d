// What shadow catchers receive of the lights: with all that is in the scene, and with what stands
// for the plate alone.
#pragma once

#include <cstdint>

namespace emberline {

struct FilmSample;

// The sums of a pixel: received R G B, unshadowed R G B, catcher, hidden, background, as a
// CatcherSample has them.
inline constexpr uint32_t kShadowSums = 9;
void add_shadow(const FilmSample& sample, double* sums);

// R G B that the plate is to be multiplied by where it shows: received over unshadowed on the
// catchers, 1 beside them. In [0, 1].
void put_shadow(const double* sums, float* rgb);
// The sum over the pixel's samples of the alpha that catchers which are not to be seen have of it.
double shadow_alpha(const double* sums);

}  // namespace emberline
