// Converts errors of linear radiance to errors of the displayed image (sRGB, [0, 1]).
#pragma once

#include <algorithm>
#include <cmath>

namespace emberline {

// Clips linear light to [0, 1] and applies the sRGB transfer function (IEC 61966-2-1). Returns 0
// for NaN. The result is accurate to 1e-6. The function has no branches, so that loops over pixels
// vectorise.
inline float display_value(float linear) {
  constexpr float kLinearLimit = 0.0031308f;  // below this the curve is linear
  const float x = linear > 0.0f ? std::min(linear, 1.0f) : 0.0f;
  // The curve is nearly straight as a function of t = 1 - x^(1/4), and is computed as 1 + t q(t).
  // This form is exact at white. The polynomial q interpolates the curve with an error of 3e-7, at
  // the Chebyshev nodes of [0, 1 - kLinearLimit^(1/4)].
  const float t = 1.0f - std::sqrt(std::sqrt(x));
  float q = 0.0528659709f;
  q = q * t - 0.0934508964f;
  q = q * t + 0.0832892284f;
  q = q * t - 0.0214407835f;
  q = q * t + 0.0283523463f;
  q = q * t + 0.064457804f;
  q = q * t + 0.586135924f;
  q = q * t - 1.75833344f;
  return x < kLinearLimit ? 12.92f * x : 1.0f + t * q;
}

inline constexpr float kMinDisplaySlope = 0.02f;

// Returns the weight that converts a squared error of linear radiance to a squared error of the
// displayed value. The weight is the squared slope of display_value() over the interval mean +-
// deviation. The interval matters near white: where noise merely raises the mean above 1, part of
// the interval is below 1, and the weight is not 0.
//
// The weight is at least min_slope^2, so that every pixel counts. This minimum is reduced where the
// displayed squared error would otherwise exceed 1/4, the largest variance of a value in [0, 1].
// The deviation is clamped to [1e-3, 1e15]. With a smaller deviation, the difference of two floats
// would lose precision; with a larger one, the weight would be 0.
inline float display_error_weight(float mean, float deviation, float min_slope = kMinDisplaySlope) {
  const float d = std::min(std::max(deviation, 1e-3f), 1e15f);
  const float slope = (display_value(mean + d) - display_value(mean - d)) / (2 * d);
  return std::max(slope * slope, std::min(min_slope * min_slope, 0.25f / (d * d)));
}

}  // namespace emberline
