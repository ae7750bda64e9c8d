// Branch-free atan2 for lookups by direction.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "renderer/core/constants.h"

namespace emberline {

// Returns atan2(y, x) with an error of 4e-7 rad (a thousandth of a texel of a 16k map), which
// environment_light_test measures. atan2(0, 0) is 0, and the result keeps the sign of a zero y.
// atan(q) on [0, 1] is computed as q P(q^2), where P is our own Chebyshev fit of degree 7 with an
// error of 7e-8. The rest of the error is rounding.
inline float fast_atan2(float y, float x) {
  const float ax = std::abs(x), ay = std::abs(y);
  const float larger = std::max(ax, ay), smaller = std::min(ax, ay);
  const float q = smaller / std::max(larger, std::numeric_limits<float>::min());
  const float t = q * q, t2 = t * t, t4 = t2 * t2;
  // Use Estrin's scheme, whose dependency chain is half as long as that of Horner's scheme.
  const float p01 = std::fma(-0.333318114f, t, 0.999999881f);
  const float p23 = std::fma(-0.140032902f, t, 0.199669614f);
  const float p45 = std::fma(-0.0588297546f, t, 0.0986886546f);
  const float p67 = std::fma(-0.00455979211f, t, 0.0237805191f);
  float angle = q * std::fma(t4, std::fma(t2, p67, p45), std::fma(t2, p23, p01));
  angle = ay > ax ? kPi / 2 - angle : angle;
  angle = x < 0.0f ? kPi - angle : angle;
  return std::copysign(angle, y);
}

}  // namespace emberline
