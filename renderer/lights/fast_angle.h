// atan2 without a branch, for the two angles that every environment lookup needs.
#pragma once

#include <cmath>
#include <limits>

#include "renderer/core/constants.h"

namespace emberline {

// atan2(y, x) to 4e-7 rad (a thousandth of a texel of a 16k map); atan2(0, 0) is 0, and the sign of
// a zero y is kept. atan(q) on [0, 1] is q P(q^2), P our own Chebyshev fit of degree 7, whose own
// error is 7e-8; the rest is rounding. environment_light_test measures it.
inline float fast_atan2(float y, float x) {
  const float ax = std::abs(x), ay = std::abs(y);
  const float larger = std::max(ax, ay), smaller = std::min(ax, ay);
  const float q = smaller / std::max(larger, std::numeric_limits<float>::min());
  const float t = q * q, t2 = t * t, t4 = t2 * t2;
  // Estrin's scheme: the chain of dependent operations is half of Horner's.
  const float p01 = 0.999999881f - 0.333318114f * t;
  const float p23 = 0.199669614f - 0.140032902f * t;
  const float p45 = 0.0986886546f - 0.0588297546f * t;
  const float p67 = 0.0237805191f - 0.00455979211f * t;
  float angle = q * ((p01 + t2 * p23) + t4 * (p45 + t2 * p67));
  angle = ay > ax ? kPi / 2 - angle : angle;
  angle = x < 0.0f ? kPi - angle : angle;
  return std::copysign(angle, y);
}

}  // namespace emberline
