// Four floats that are computed with as one (a GCC and Clang vector): a colour, and in its fourth
// lane whatever a function finds useful to compute alongside.
#pragma once

#include "renderer/core/vector.h"

namespace emberline {

using Color4 [[gnu::vector_size(16)]] = float;

inline Color4 splat4(float x) { return Color4{x, x, x, x}; }
inline Color4 color4(const Rgb& c, float fourth = 0.0f) { return Color4{c.x, c.y, c.z, fourth}; }
inline Rgb to_rgb(Color4 c) { return Rgb(c[0], c[1], c[2]); }

}  // namespace emberline
