// Means over squares of pixels. Each square is summed separately, not as a running sum, so that a
// pixel's bits do not depend on where a band begins.
#pragma once

#include "renderer/reconstruction/bordered_plane.h"

namespace emberline {

// For each pixel, the sum over the (2 radius + 1)^2 pixels around it; radius must be at most kPad.
// Pixels outside the image count as 0, whatever the border of `in` contains.
BorderedPlane box_sum(const BorderedPlane& in, int radius);

// box_sum() divided by the number of those pixels that are inside the image.
BorderedPlane box_mean(const BorderedPlane& in, int radius);

}  // namespace emberline
