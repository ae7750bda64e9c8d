// Constants used in more than one place.
#pragma once

#include <numbers>

namespace emberline {

inline constexpr float kPi = std::numbers::pi_v<float>;
inline constexpr float kInvPi = std::numbers::inv_pi_v<float>;
inline constexpr double kPiD = std::numbers::pi;

// The largest float below 1. Samplers return no larger number.
inline constexpr float kOneMinusEpsilon = 0x1.fffffep-1f;

// Unit roundoff of float, 2^-24, which is half an ulp of 1.
inline constexpr float kFloatUnit = 0x1p-24f;

// A microfacet lobe with a smaller alpha is treated as a mirror. pbrt-v4 uses the same limit
// (TrowbridgeReitzDistribution::EffectivelySmooth, 1e-3).
inline constexpr float kMirrorAlpha = 1e-3f;

}  // namespace emberline
