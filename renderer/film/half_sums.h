// What a denoiser wants of a frame beside its picture: the two halves of each pixel's samples
// apart, and what they saw (renderer/reconstruction/denoise.h).
//
// The halves are the film's own (FilmTile::add), which has their colours; here is the rest: what
// was seen, and what the pixel's samples count for the pixels around it (PixelFilter::shares). It
// costs 416 bytes a pixel, and with light groups 24 for each and 24 more.
#pragma once

#include <array>
#include <cstdint>

#include "renderer/core/vector.h"
#include "renderer/core/zeroed_array.h"
#include "renderer/film/light_group_sums.h"
#include "renderer/film/sample_shares.h"
#include "renderer/film/sample_value.h"

namespace emberline {

class Archive;

// R G B and the weight, of each of kSharing.
inline constexpr size_t kSharedValues = 4 * kSharing;

class HalfSums {
 public:
  // light_groups: kept by half too; -1: there are none. Not `kept`: nothing is, and costs nothing.
  HalfSums(bool kept, int light_groups)
      : kept_(kept), second_lights_(kept && light_groups > 0 ? light_groups : -1) {}

  // Clears to no samples of so many pixels.
  void reset(size_t pixels);
  bool empty() const { return sums_.empty(); }

  // Finite. A pixel's samples have one owner, and come in index order.
  void add(size_t pixel, int half, const DenoiserFeatures& features);
  void add_shares(size_t pixel, int half, const Rgb& radiance, const SampleShares& shares);
  // Of a sample of the second half, likewise; those of the first are what this leaves of the
  // film's.
  void add_second_lights(size_t pixel, float filter_weight, const LightGroupValues& values,
                         int lane) {
    if (!second_lights_.empty()) second_lights_.add(pixel, filter_weight, 0.0f, values, lane);
  }
  void copy(const HalfSums& from, size_t from_pixel, size_t pixel);
  void add_sums(const HalfSums& from, size_t pixel);

  // Sums over the samples of a half, in the order of DenoiserFeatures.
  const std::array<double, kFeatureValues>& sums(size_t pixel, int half) const {
    return sums_[pixel].halves[half];
  }
  // Of radiance x share, and of the shares.
  const std::array<float, kSharedValues>& shared(size_t pixel, int half) const {
    return sums_[pixel].shared[half];
  }
  const LightGroupSums& second_lights() const { return second_lights_; }

  void archive(Archive& archive);  // throws InputError
  uint64_t bytes() const { return sums_.capacity() * sizeof(Sums) + second_lights_.bytes(); }

 private:
  struct Sums {
    std::array<double, kFeatureValues> halves[2];
    std::array<float, kSharedValues> shared[2];
  };

  bool kept_;
  ZeroedArray<Sums> sums_;
  LightGroupSums second_lights_;
};

}  // namespace emberline
