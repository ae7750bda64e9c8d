// Means over squares of pixels. Each is summed on its own, never rolled from its neighbour's, so
// that a pixel has the same bits wherever a band begins.
#pragma once

#include "renderer/reconstruction/bordered_plane.h"

namespace emberline {

// The sum over (2 radius + 1)^2 pixels, those outside the picture left out; radius at most kPad.
// The border of `in` is taken for 0.
BorderedPlane box_sum(const BorderedPlane& in, int radius);

// The same over the number of pixels inside.
BorderedPlane box_mean(const BorderedPlane& in, int radius);

}  // namespace emberline
