// Key frames and their interpolation over time (glTF 2.0, section 3.11 and appendix C). Plain data
// and pure functions.
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
  Numbers values;  // finite, by key; each key of a cubic spline has in-tangent, value, out-tangent

  double last() const { return times->back(); }
};

// Writes the value at `time` to `value`, which must have `width` numbers. Before the first key it
// is the first value, after the last key the last one, and in between it is interpolated; at a key
// it is exact. Interpolated rotations are unit quaternions. Takes logarithmic time in the number of
// keys.
void sample_keys(const KeyFrames& keys, double time, std::span<double> value);

// Spherical interpolation along the shorter arc between two non-zero quaternions; `share` is in [0,
// 1]. The result has unit length.
Quaternion slerp(const Quaternion& from, const Quaternion& to, double share);

}  // namespace emberline
