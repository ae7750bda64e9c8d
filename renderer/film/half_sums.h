// What a denoiser wants of a frame beside its picture: the two halves of each pixel's samples
// apart, and what they saw (renderer/reconstruction/denoise.h).
//
// The halves are the film's own (PixelSums), which has their colours; here is the rest: what was
// seen, and what the pixel's samples count for the pixels around it (PixelFilter::shares).
#pragma once

#include <array>
#include <cstddef>

#include "renderer/core/vector.h"
#include "renderer/film/sample_shares.h"
#include "renderer/film/sample_value.h"

namespace emberline {

// R G B and the weight, of each of kSharing.
inline constexpr size_t kSharedValues = 4 * kSharing;

struct HalfSums {
  // Sums over the samples of a half, in the order of DenoiserFeatures.
  std::array<double, kFeatureValues> features[2];
  // Of radiance x share, and of the shares.
  std::array<float, kSharedValues> shared[2];

  // Finite. A pixel's samples come in index order.
  void add_features(int half, const DenoiserFeatures& more);
  void add_shares(int half, const Rgb& radiance, const SampleShares& shares);
  void merge(const HalfSums& more);
  bool is_sound() const;
};

}  // namespace emberline
