// A density for sampling the cosine lobe: more samples go to directions that light comes from.
//
// A direction of the cosine lobe is a point of the unit square (x: azimuth in turns, y: square of
// the sine of the polar angle; Malley's method). The guide divides the square into equal bins and
// gives each a probability. It maps the sampler's point into the square monotonically in each
// coordinate, so stratified points stay stratified. Directions are in local shading space.
#pragma once

#include <algorithm>
#include <array>
#include <span>

#include "renderer/core/constants.h"
#include "renderer/core/fast_angle.h"
#include "renderer/core/vector.h"

namespace emberline {

class CosineGuide {
 public:
  static constexpr int kSize = 16;  // rows, and columns of each row
  static constexpr int kBins = kSize * kSize;

  CosineGuide() = default;
  // `weights` has one positive weight for each bin, row by row; their sum must be finite.
  explicit CosineGuide(std::span<const float, kBins> weights);

  // Maps a uniform point of the unit square to a point that has the guide's density.
  Vec2f sample(const Vec2f& u) const {
    const Place row = find(rows_, u.y);
    return {find(columns_[size_t(row.bin)], u.x).position, row.position};
  }
  // Returns the density relative to the plain cosine lobe, for a direction above the surface.
  float density(const Vec3f& wi) const { return density(bin_of(wi)); }
  // Returns the direction in the middle of the bin with the greatest density.
  Vec3f main_direction() const;
  // The direction of a point of the square, and the bin of a direction.
  static Vec3f direction_of(const Vec2f& u);
  static int bin_of(const Vec3f& wi) {
    const float turns = fast_atan2(wi.y, wi.x) * (0.5f * kInvPi);
    const float x = turns < 0.0f ? turns + 1.0f : turns, y = fma(wi.x, wi.x, square(wi.y));
    return std::min(int(y * kSize), kSize - 1) * kSize + std::min(int(x * kSize), kSize - 1);
  }

 private:
  float density(int bin) const {
    return density(rows_, bin / kSize) * density(columns_[size_t(bin / kSize)], bin % kSize);
  }
  // Running sums of probabilities. The last one is 1.
  using Sums = std::array<float, kSize>;
  struct Place {
    int bin;
    float position;
  };
  static float before(const Sums& sums, int bin) { return bin > 0 ? sums[size_t(bin) - 1] : 0.0f; }
  static float density(const Sums& sums, int bin) {
    return (sums[size_t(bin)] - before(sums, bin)) * float(kSize);
  }
  static Place find(const Sums& sums, float u) {
    int bin = 0;
    for (const float sum : sums) bin += sum <= u;  // vectorises; u < 1
    const float start = before(sums, bin), probability = sums[size_t(bin)] - start;
    const float position = (float(bin) + (u - start) / probability) * (1.0f / kSize);
    return {bin, std::min(position, kOneMinusEpsilon)};
  }

  alignas(64) Sums rows_{};
  std::array<Sums, kSize> columns_{};  // of each row
};

}  // namespace emberline
