// Key frames, and what they come to at a time: glTF 2.0, section 3.11 and appendix C. Plain data
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

// Of one property. The numbers are shared: hundreds of properties move at the same times.
struct KeyFrames {
  using Numbers = std::shared_ptr<const std::vector<float>>;

  Interpolation interpolation = Interpolation::kLinear;
  bool rotations = false;  // the values are quaternions, none of them zero
  size_t width = 1;        // numbers of a value
  Numbers times;           // seconds, finite and growing; one at least
  Numbers values;  // finite, by key; of a cubic spline in-tangent, value, out-tangent of each

  double last() const { return times->back(); }
};

// Before the first key and behind the last its value, at a key the key's own, and between two as
// the interpolation says. `value` has as many numbers as the keys' values. Rotations that are
// interpolated are unit quaternions. Takes the logarithm of the number of keys.
void sample_keys(const KeyFrames& keys, double time, std::span<double> value);

// At `share` (0 to 1) of the shorter great arc between two quaternions, which need not have unit
// length, but some; the result has it.
Quaternion slerp(const Quaternion& from, const Quaternion& to, double share);

}  // namespace emberline
