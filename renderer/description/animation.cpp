#include "renderer/description/animation.h"

#include <algorithm>
#include <cmath>

namespace emberline {
namespace {

// Between `key` and the one behind it.
struct Segment {
  size_t key = 0;
  double share = 0.0;     // of it that is over; 0: at the key, or held
  double duration = 0.0;  // seconds
};

// A time that rounds to a key's is at the key: frame 1 of 24 a second lies a little before the
// float that stands for it, and a step must be over by then.
Segment find_segment(const std::vector<float>& times, double time) {
  const auto behind = std::upper_bound(times.begin(), times.end(), float(time));
  if (behind == times.begin()) return {};
  const auto key = behind - 1;
  if (behind == times.end()) return {size_t(key - times.begin())};
  const double duration = double(*behind) - double(*key);
  const double share = std::max(0.0, (time - double(*key)) / duration);
  return {size_t(key - times.begin()), share, duration};
}

double length_of(std::span<const double> q) {
  double sum = 0.0;
  for (const double component : q) sum += component * component;
  return std::sqrt(sum);
}

Quaternion scaled(const Quaternion& q, double factor) {
  return {q[0] * factor, q[1] * factor, q[2] * factor, q[3] * factor};
}

Quaternion weighted_sum(const Quaternion& a, double wa, const Quaternion& b, double wb) {
  Quaternion sum;
  for (size_t c = 0; c < sum.size(); ++c) sum[c] = a[c] * wa + b[c] * wb;
  return sum;
}

Quaternion quaternion_at(const float* numbers) {
  return {numbers[0], numbers[1], numbers[2], numbers[3]};
}

// Appendix C, "Cubic Spline Interpolation". `at` is the first key's in-tangent.
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

// A spline through opposite quaternions may pass through none: the nearer key then stands.
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
  const Quaternion a = scaled(from, 1.0 / length_of(from));
  Quaternion b = scaled(to, 1.0 / length_of(to));
  const double cosine = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
  if (cosine < 0.0) b = scaled(b, -1.0);
  // From chords: the arc cosine of nearly 1 would lose half the digits.
  const double angle = 2.0 * std::atan2(length_of(weighted_sum(a, 1.0, b, -1.0)),
                                        length_of(weighted_sum(a, 1.0, b, 1.0)));
  if (angle == 0.0) return a;
  const double sine = std::sin(angle);
  return weighted_sum(a, std::sin(angle * (1.0 - share)) / sine, b, std::sin(angle * share) / sine);
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
