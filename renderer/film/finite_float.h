// What a film writes of its sums.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace emberline {

// Sums, and squares of finite radiance, may exceed float, and those of a checkpoint that somebody
// else has written double, too; what is written stays finite (law 4). NaN, of such sums, is 0.
inline float to_finite_float(double x) {
  constexpr double kMost = std::numeric_limits<float>::max();
  return std::isnan(x) ? 0.0f : float(std::clamp(x, -kMost, kMost));
}

}  // namespace emberline
