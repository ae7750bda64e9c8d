// What a denoiser wants of a frame beside its picture: the two halves of each pixel's samples
// apart, and what they saw (renderer/reconstruction/denoise.h).
//
// The halves are the film's own (FilmTile::add), which has their colours; here is the rest: what
// was seen, and what the pixel's samples count for the pixels around it (PixelFilter::shares). It
// costs 416 bytes a pixel, and with light groups 24 for each and 24 more.
#pragma once

#include <array>
#include <cstdint>

#include "renderer/core/archive.h"
#include "renderer/core/vector.h"
#include "renderer/core/zeroed_array.h"
#include "renderer/film/filter.h"
#include "renderer/film/light_group_sums.h"

namespace emberline {

// What a sample shows: the first surface that is neither a smooth mirror nor smooth clear glass,
// seen in and through those; or the background. Every value is made to have a mean that is linear
// in what share of a pixel it covers.
struct SeenSurface {
  // Directional albedo and own light, in the colours of the mirrors and glasses before it; at
  // most 1. Of the background its light.
  Rgb albedo = Rgb(0.0f);
  Vec3f normal = Vec3f(0.0f);  // shading normal, world axes; the background has none
  // One over the depth along the viewing axis, in scene units; behind mirrors that of the mirrored
  // surface. Unlike depth it is linear in the picture for a plane, and 0 for the background.
  float nearness = 0.0f;
  // 1 if the light that was sampled at the surface is seen from there.
  float visibility = 0.0f;

  static constexpr float kMostNearness = 1e6f;
};
inline constexpr size_t kSeenValues = 8;  // as many numbers, in this order

bool is_finite(const SeenSurface& seen);

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
  void add(size_t pixel, int half, const SeenSurface& seen);
  void add_shares(size_t pixel, int half, const Rgb& radiance, const SampleShares& shares);
  // Of a sample of the second half, likewise; those of the first are what this leaves of the
  // film's.
  void add_second_lights(size_t pixel, float filter_weight, const LightGroupValues& values,
                         int lane) {
    if (!second_lights_.empty()) second_lights_.add(pixel, filter_weight, 0.0f, values, lane);
  }
  void copy(const HalfSums& from, size_t from_pixel, size_t pixel);
  void add_sums(const HalfSums& from, size_t pixel);

  // Sums over the samples of a half, in the order of SeenSurface.
  const std::array<double, kSeenValues>& sums(size_t pixel, int half) const {
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
    std::array<double, kSeenValues> halves[2];
    std::array<float, kSharedValues> shared[2];
  };

  bool kept_;
  ZeroedArray<Sums> sums_;
  LightGroupSums second_lights_;
};

}  // namespace emberline
