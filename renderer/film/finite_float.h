// Conversion of a film's sums to finite floats.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

namespace emberline {

// Converts a sum to a finite float, since files must contain only finite values (law 4). Sums and
// squares of finite radiance may exceed the range of float, and sums from a foreign checkpoint may
// even exceed that of double. NaN becomes 0.
inline float to_finite_float(double x) {
  constexpr double kMaxFloat = std::numeric_limits<float>::max();
  return std::isnan(x) ? 0.0f : float(std::clamp(x, -kMaxFloat, kMaxFloat));
}

template <class Values>
bool all_finite(const Values& values) {
  return std::ranges::all_of(values, [](auto value) { return std::isfinite(value); });
}
template <class T>
bool all_finite(const T* values, size_t count) {
  return all_finite(std::span(values, count));
}

}  // namespace emberline
