// Sums and means over squares of pixels. Each square is summed separately, not as a running sum, so
// that a pixel's bits do not depend on where a band of rows begins.
#pragma once

#include "renderer/reconstruction/bordered_plane.h"

namespace emberline {

// Returns, for each pixel, the sum over the (2 radius + 1)^2 pixels around it. The radius must be
// at most kPad. Pixels outside the image count as 0, whatever the border of `in` contains.
BorderedPlane box_sum(const BorderedPlane& in, int radius);

// Returns box_sum(), with each sum divided by the number of its pixels that are inside the image.
BorderedPlane box_mean(const BorderedPlane& in, int radius);

}  // namespace emberline
