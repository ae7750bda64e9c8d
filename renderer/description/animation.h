// Key frames and their interpolation over time (glTF 2.0, section 3.11 and appendix C). This file
// has only plain data and pure functions.
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
  bool rotations = false;  // true: the values are non-zero quaternions
  size_t width = 1;        // numbers per value
  Numbers times;           // seconds, finite, increasing; at least one
  Numbers values;  // finite; per key: the value, or in-tangent, value and out-tangent for splines

  double last() const { return times->back(); }
};

// Writes the value at `time` to `value`, which must have `width` numbers. Before the first key,
// this is the value of the first key; after the last key, it is the value of the last key. At a
// key, it is exactly the key's value. Between keys, it is interpolated. Interpolated rotations are
// unit quaternions. Takes time logarithmic in the number of keys.
void sample_keys(const KeyFrames& keys, double time, std::span<double> value);

// Interpolates spherically along the shorter arc between two non-zero quaternions, with `share` in
// [0, 1]. The result has unit length.
Quaternion slerp(const Quaternion& from, const Quaternion& to, double share);

}  // namespace emberline
