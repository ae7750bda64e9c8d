// Means over squares of pixels. Each is summed on its own, never rolled from its neighbour's, so
// that a pixel has the same bits wherever a band begins.
#pragma once

#include "renderer/reconstruction/plane.h"

namespace emberline {

// The sum over (2 radius + 1)^2 pixels, those outside the picture left out; radius at most kPad.
// The border of `in` is taken for 0.
Plane box_sum(const Plane& in, int radius);

// The same over the number of pixels inside.
Plane box_mean(const Plane& in, int radius);

}  // namespace emberline
