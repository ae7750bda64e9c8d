// Key frames and their values over time: glTF 2.0, section 3.11 and appendix C. Plain data and pure
// functions.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace emberline {

enum class Interpolation : uint8_t { kStep, kLinear, kCubicSpline };

using Quaternion = std::array<double, 4>;  // x, y, z, w

// Key frames of one property. Hundreds of properties may share the same times.
struct KeyFrames {
  using Numbers = std::shared_ptr<const std::vector<float>>;

  Interpolation interpolation = Interpolation::kLinear;
  bool rotations = false;  // the values are non-zero quaternions
  size_t width = 1;        // numbers per value
  Numbers times;           // seconds, finite, increasing; at least one
  Numbers values;  // finite, by key; a cubic spline has in-tangent, value, out-tangent per key

  double last() const { return times->back(); }
};

// The first value before the first key, the last one after the last key, and in between the
// interpolated one; exact at a key. `value` must have `width` numbers. Interpolated rotations are
// unit quaternions. Logarithmic in the number of keys.
void sample_keys(const KeyFrames& keys, double time, std::span<double> value);

// Spherical interpolation by `share` (0 to 1) along the shorter arc between two non-zero
// quaternions. The result has unit length.
Quaternion slerp(const Quaternion& from, const Quaternion& to, double share);

}  // namespace emberline
