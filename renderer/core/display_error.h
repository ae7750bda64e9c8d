// What an error of linear radiance is in the picture as it is looked at (sRGB, [0, 1]).
#pragma once

#include <algorithm>
#include <cmath>

namespace emberline {

// The sRGB transfer function (IEC 61966-2-1), linear light to [0, 1], clipped there; NaN gives 0.
// Within 1e-6, without a branch, so that loops over pixels vectorise.
inline float display_value(float linear) {
  constexpr float kStraight = 0.0031308f;  // below, the curve is a line
  const float x = linear > 0.0f ? std::min(linear, 1.0f) : 0.0f;
  // The curve over t = 1 - x^(1/4), which bends little: 1 + t q(t), exact at white. q interpolates
  // in the Chebyshev nodes of [0, 1 - kStraight^(1/4)]; its degree makes the error 3e-7.
  const float t = 1.0f - std::sqrt(std::sqrt(x));
  float q = 0.0528659709f;
  q = q * t - 0.0934508964f;
  q = q * t + 0.0832892284f;
  q = q * t - 0.0214407835f;
  q = q * t + 0.0283523463f;
  q = q * t + 0.064457804f;
  q = q * t + 0.586135924f;
  q = q * t - 1.75833344f;
  return x < kStraight ? 12.92f * x : 1.0f + t * q;
}

inline constexpr float kLeastDisplaySlope = 0.02f;

// The squared slope of display_value() over mean +- deviation, so that clipped white and noise
// about to leave it are told apart; at least least_slope^2, so that no pixel counts for
// nothing, but not so much that the squared error were above 1/4, which is the most that a value in
// [0, 1] varies. A deviation below .001 is taken for that: the slope is a difference of two floats;
// so is one above 1e15, so that the weight is none of 0.
inline float display_error_weight(float mean, float deviation,
                                  float least_slope = kLeastDisplaySlope) {
  const float d = std::min(std::max(deviation, 1e-3f), 1e15f);
  const float slope = (display_value(mean + d) - display_value(mean - d)) / (2 * d);
  return std::max(slope * slope, std::min(least_slope * least_slope, 0.25f / (d * d)));
}

}  // namespace emberline
