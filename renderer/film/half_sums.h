// Denoiser inputs other than the picture: sums of the features and shares over each half of a
// pixel's samples (renderer/reconstruction/denoise.h). The colours of the halves are in PixelSums.
#pragma once

#include <array>
#include <cstddef>

#include "renderer/core/vector.h"
#include "renderer/film/sample_shares.h"
#include "renderer/film/sample_value.h"

namespace emberline {

// R G B and the weight, for each of the kSharedPixels pixels.
inline constexpr size_t kSharedValues = 4 * kSharedPixels;

struct HalfSums {
  // Sums over the samples of each half, in the order of DenoiserFeatures.
  std::array<double, kFeatureValues> features[2];
  // Sums of radiance x share, and sums of the shares.
  std::array<float, kSharedValues> shared[2];

  // Arguments must be finite, and a pixel's samples must be added in index order.
  void add_features(int half, const DenoiserFeatures& more);
  void add_shares(int half, const Rgb& radiance, const SampleShares& shares);
  void merge(const HalfSums& more);
  bool is_valid() const;
};

}  // namespace emberline
