// How much of each filtered picture a pixel takes. With the raw picture r and candidates F_k, the
// expected squared error of r + sum_k a_k (F_k - r) is, whatever the bias of F_k,
//   V - 2 sum_k a_k (V - C_k) + sum_kl a_k a_l D_kl,
// V the variance of r; C_k what the noises of r and F_k have in common; D_kl the mean product of
// F_k - r and F_l - r. All of them can be measured (Stein, "Estimation of the Mean of a
// Multivariate Normal Distribution", 1981), and are pooled over neighbours. The shares a_k that
// make it least go to 0 where the filter's bias exceeds the noise, so that the picture converges.
#pragma once

#include <array>
#include <optional>

#include "renderer/reconstruction/outliers.h"
#include "renderer/reconstruction/regression.h"

namespace emberline {

struct Candidate {
  ColourPlanes colour;
  ColourPlanes difference;              // of the filtered halves
  std::array<BorderedPlane, 2> weight;  // of what is said of the pixel, in either half
};
using Candidates = std::array<Candidate, kBandwidths>;

// What is decided for the picture as a whole, and holds for its parts.
struct Blend {
  std::array<BorderedPlane, kBandwidths> shares;  // of each candidate; the rest is raw
  ColourPlanes colour;
  std::optional<LostLight> lost_light;  // already given back to `colour`
  BorderedPlane error_before,
      error;  // expected squared error of the displayed pixel, raw and blended
};

// A pixel depends on those kBlendReach around it.
inline constexpr int kPoolRadius = 8;    // of the error's terms
inline constexpr int kSmoothRadius = 2;  // of the shares
inline constexpr int kBlendReach = 2 * kPoolRadius + kSmoothRadius + kLostLightReach;
Blend blend(const Halves& halves, const Candidates& candidates);

}  // namespace emberline
