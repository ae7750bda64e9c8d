// Chooses, for each pixel, the weights of the filtered images. Let r be the raw image, and let the
// candidates F_k be the filtered images. Whatever the bias of F_k, the expected squared error of
// r + sum_k a_k (F_k - r) is
//   V - 2 sum_k a_k (V - C_k) + sum_kl a_k a_l D_kl,
// where V is the variance of r, C_k the covariance of r and F_k, and D_kl the mean product of F_k -
// r and F_l - r. All these terms can be measured (Stein, "Estimation of the Mean of a Multivariate
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
  ColourPlanes difference;              // difference of the filtered halves
  std::array<BorderedPlane, 2> weight;  // total weight of the fits at the pixel, per half
};
using Candidates = std::array<Candidate, kBandwidths>;

// Weights and errors of the whole image; the weights also apply to its parts.
struct Blend {
  std::array<BorderedPlane, kBandwidths> shares;  // weight of each candidate; r gets the rest
  ColourPlanes colour;
  std::optional<OutlierEnergy> outlier_energy;  // the restored light is already in `colour`
  // Expected squared error of the displayed pixel, in the raw and in the blended image.
  BorderedPlane error_before, error;
};

// The result at a pixel depends on pixels up to kBlendReach away.
inline constexpr int kPoolRadius = 8;    // for pooling the error's terms
inline constexpr int kSmoothRadius = 2;  // for smoothing the weights
inline constexpr int kBlendReach = 2 * kPoolRadius + kSmoothRadius + kOutlierEnergyReach;
Blend blend(const Halves& halves, const Candidates& candidates);

}  // namespace emberline
