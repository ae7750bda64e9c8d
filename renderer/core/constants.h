// Numbers used in more than one place.
#pragma once

#include <numbers>

namespace emberline {

inline constexpr float kPi = std::numbers::pi_v<float>;
inline constexpr float kInvPi = std::numbers::inv_pi_v<float>;
inline constexpr double kPiD = std::numbers::pi;

// The largest float below 1: every sampler's numbers are at most this.
inline constexpr float kOneMinusEpsilon = 0x1.fffffep-1f;

// Rounding unit of float, 2^-24; one ulp of 1 is twice this.
inline constexpr float kFloatUnit = 0x1p-24f;

// A microfacet lobe narrower than this alpha is a mirror. pbrt-v4 uses the same limit
// (TrowbridgeReitzDistribution::EffectivelySmooth, 1e-3).
inline constexpr float kMirrorAlpha = 1e-3f;

}  // namespace emberline
