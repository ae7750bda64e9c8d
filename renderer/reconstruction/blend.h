// Chooses the weight of each filtered image per pixel. With the raw image r and candidates F_k, the
// expected squared error of r + sum_k a_k (F_k - r) is, for any bias of F_k,
//   V - 2 sum_k a_k (V - C_k) + sum_kl a_k a_l D_kl,
// where V is the variance of r, C_k the covariance of r and F_k, and D_kl the mean product of F_k -
// r and F_l - r. All of them can be measured (Stein, "Estimation of the Mean of a Multivariate
// Normal Distribution", 1981) and are pooled over neighbours. The weights a_k that minimise the
// error go to 0 where the filter's bias exceeds the noise, so the image converges.
#pragma once

#include <array>
#include <optional>

#include "renderer/reconstruction/outliers.h"
#include "renderer/reconstruction/regression.h"

namespace emberline {

struct Candidate {
  ColourPlanes colour;
  ColourPlanes difference;              // of the filtered halves
  std::array<BorderedPlane, 2> weight;  // total weight of the fits at the pixel, per half
};
using Candidates = std::array<Candidate, kBandwidths>;

// Weights and errors for the whole image; they also apply to its parts.
struct Blend {
  std::array<BorderedPlane, kBandwidths> shares;  // of each candidate; the rest is raw
  ColourPlanes colour;
  std::optional<OutlierEnergy> outlier_energy;  // already returned to `colour`
  // Expected squared error of the displayed pixel, raw and blended.
  BorderedPlane error_before, error;
};

// A pixel depends on those up to kBlendReach around it.
inline constexpr int kPoolRadius = 8;    // of the error's terms
inline constexpr int kSmoothRadius = 2;  // of the weights
inline constexpr int kBlendReach = 2 * kPoolRadius + kSmoothRadius + kOutlierEnergyReach;
Blend blend(const Halves& halves, const Candidates& candidates);

}  // namespace emberline
