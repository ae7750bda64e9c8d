#include "renderer/description/animation.h"

#include <Imath/ImathQuat.h>

#include <algorithm>
#include <cmath>

namespace emberline {
namespace {

// A position between `key` and the next one.
struct Segment {
  size_t key = 0;
  double share = 0.0;     // fraction of the segment before the time; 0 outside all keys
  double duration = 0.0;  // seconds
};

// Compares the time as a float, because the keys' times are floats. As a double, the time of frame
// 1 at 24 frames per second is slightly less than that of its key, which was rounded up. A step at
// this key would then appear one frame late.
Segment find_segment(const std::vector<float>& times, double time) {
  const auto next = std::upper_bound(times.begin(), times.end(), float(time));
  if (next == times.begin()) return {};
  const auto key = next - 1;
  if (next == times.end()) return {size_t(key - times.begin())};
  const double duration = double(*next) - double(*key);
  const double share = std::max(0.0, (time - double(*key)) / duration);
  return {size_t(key - times.begin()), share, duration};
}

double length_of(std::span<const double> q) {
  double sum = 0.0;
  for (const double component : q) sum += component * component;
  return std::sqrt(sum);
}

Quaternion quaternion_at(const float* numbers) {
  return {numbers[0], numbers[1], numbers[2], numbers[3]};
}

// Interpolates as in glTF 2.0, appendix C, "Cubic Spline Interpolation". `at` points to the
// in-tangent of the segment's first key.
void sample_spline(const float* at, size_t width, const Segment& segment, std::span<double> value) {
  const double t = segment.share, t2 = t * t, t3 = t2 * t;
  const float *from = at + width, *out_tangent = at + 2 * width;
  const float *in_tangent = at + 3 * width, *to = at + 4 * width;
  for (size_t c = 0; c < width; ++c) {
    value[c] = (2.0 * t3 - 3.0 * t2 + 1.0) * double(from[c]) +
               segment.duration * (t3 - 2.0 * t2 + t) * double(out_tangent[c]) +
               (3.0 * t2 - 2.0 * t3) * double(to[c]) +
               segment.duration * (t3 - t2) * double(in_tangent[c]);
  }
}

// Normalises a quaternion that a spline has interpolated. Between opposite quaternions, the result
// of the spline may be zero; the nearer key is then used instead.
void normalise(std::span<double> value, const float* from, const float* to, double share) {
  double length = length_of(value);
  if (!(length > 0.0)) {
    std::copy_n(share < 0.5 ? from : to, value.size(), value.begin());
    length = length_of(value);
  }
  for (double& component : value) component /= length;
}

}  // namespace

Quaternion slerp(const Quaternion& from, const Quaternion& to, double share) {
  const auto unit = [](const Quaternion& q) {
    return Imath::Quatd(q[3], q[0], q[1], q[2]).normalized();
  };
  const Imath::Quatd q = Imath::slerpShortestArc(unit(from), unit(to), share);
  return {q.v.x, q.v.y, q.v.z, q.r};
}

void sample_keys(const KeyFrames& keys, double time, std::span<double> value) {
  const bool spline = keys.interpolation == Interpolation::kCubicSpline;
  const size_t width = keys.width, stride = spline ? 3 * width : width;
  const Segment segment = find_segment(*keys.times, time);
  const float* at = keys.values->data() + segment.key * stride;
  const float* from = spline ? at + width : at;
  if (segment.share == 0.0 || keys.interpolation == Interpolation::kStep) {
    std::copy_n(from, width, value.begin());
    return;
  }
  const float* to = from + stride;
  if (spline) {
    sample_spline(at, width, segment, value);
    if (keys.rotations) normalise(value, from, to, segment.share);
  } else if (keys.rotations) {
    std::ranges::copy(slerp(quaternion_at(from), quaternion_at(to), segment.share), value.begin());
  } else {
    for (size_t c = 0; c < width; ++c) {
      value[c] = (1.0 - segment.share) * double(from[c]) + segment.share * double(to[c]);
    }
  }
}

}  // namespace emberline
