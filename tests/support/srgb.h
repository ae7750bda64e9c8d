// The sRGB transfer function in double precision, as a reference.
#pragma once

#include <algorithm>
#include <cmath>

namespace emberline::test {

// Encodes a linear value as in IEC 61966-2-1. Clips the value to [0, 1], as a display does. NaN
// becomes black.
inline double srgb(double x) {
  x = x > 0 ? std::min(x, 1.0) : 0.0;
  return x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
}

}  // namespace emberline::test
