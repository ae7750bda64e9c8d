// Means over squares of pixels. Each is summed independently, not as a running sum, so that a pixel
// has the same bits wherever a band begins.
#pragma once

#include "renderer/reconstruction/bordered_plane.h"

namespace emberline {

// The sum over (2 radius + 1)^2 pixels, without those outside the image; radius at most kPad. The
// border of `in` counts as 0.
BorderedPlane box_sum(const BorderedPlane& in, int radius);

// box_sum() divided by the number of pixels inside.
BorderedPlane box_mean(const BorderedPlane& in, int radius);

}  // namespace emberline
