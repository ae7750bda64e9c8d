// A GCC or Clang vector of four floats. The first three are a colour. A function may compute
// another value in the fourth lane at the same time.
#pragma once

#include "renderer/core/vector.h"

namespace emberline {

using Color4 [[gnu::vector_size(16)]] = float;

inline Color4 splat4(float x) { return Color4{x, x, x, x}; }
inline Color4 color4(const Rgb& c, float fourth = 0.0f) { return Color4{c.x, c.y, c.z, fourth}; }
[[gnu::always_inline]] inline Color4 fma(Color4 a, Color4 b, Color4 c) {
#ifdef __FMA__
  return __builtin_ia32_vfmaddps(a, b, c);
#else
  return Color4{fma(a[0], b[0], c[0]), fma(a[1], b[1], c[1]), fma(a[2], b[2], c[2]),
                fma(a[3], b[3], c[3])};
#endif
}
[[gnu::always_inline]] inline Color4 fma(Color4 a, float b, Color4 c) {
  return fma(a, splat4(b), c);
}
inline Rgb to_rgb(Color4 c) { return Rgb(c[0], c[1], c[2]); }

}  // namespace emberline
