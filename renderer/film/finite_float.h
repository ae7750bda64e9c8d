// What a film writes of its sums.
#pragma once

#include <algorithm>
#include <limits>

namespace emberline {

// Squares of finite radiance may exceed float; what is written stays finite (law 4).
inline float to_finite_float(double x) {
  constexpr double kMost = std::numeric_limits<float>::max();
  return float(std::clamp(x, -kMost, kMost));
}

}  // namespace emberline
