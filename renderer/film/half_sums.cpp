#include "renderer/film/half_sums.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "renderer/core/archive.h"
#include "renderer/core/color4.h"

namespace emberline {
namespace {

std::array<float, kFeatureValues> values_of(const DenoiserFeatures& features) {
  return {features.albedo.x, features.albedo.y, features.albedo.z, features.normal.x,
          features.normal.y, features.normal.z, features.nearness, features.visibility};
}

// Four sums more at a time: no lane is NaN, since none of the sums is infinite.
void add_finite(Color4 more, float* sums) {
  constexpr float kMost = std::numeric_limits<float>::max();
  Color4 sum;
  std::memcpy(&sum, sums, sizeof sum);
  sum += more;
  sum = sum > kMost ? splat4(kMost) : sum;
  sum = sum < -kMost ? splat4(-kMost) : sum;
  std::memcpy(sums, &sum, sizeof sum);
}

}  // namespace

bool is_finite(const DenoiserFeatures& features) {
  return std::ranges::all_of(values_of(features), [](float value) { return std::isfinite(value); });
}

void HalfSums::reset(size_t pixels) {
  if (!kept_) return;
  sums_.reset(pixels);
  second_lights_.reset(pixels);
}

void HalfSums::add(size_t pixel, int half, const DenoiserFeatures& features) {
  std::array<double, kFeatureValues>& sums = sums_[pixel].halves[half];
  const std::array<float, kFeatureValues> values = values_of(features);
  for (size_t i = 0; i < kFeatureValues; ++i) sums[i] += double(values[i]);
}

void HalfSums::add_shares(size_t pixel, int half, const Rgb& radiance, const SampleShares& shares) {
  float* sums = sums_[pixel].shared[half].data();
  const Color4 value = color4(radiance, 1.0f);
  for (size_t k = 0; k < kSharing; ++k) add_finite(value * shares[k], sums + 4 * k);
}

void HalfSums::copy(const HalfSums& from, size_t from_pixel, size_t pixel) {
  if (!kept_) return;
  sums_[pixel] = from.sums_[from_pixel];
  if (!second_lights_.empty()) second_lights_.copy(from.second_lights_, from_pixel, pixel);
}

void HalfSums::add_sums(const HalfSums& from, size_t pixel) {
  if (!kept_) return;
  for (int half = 0; half < 2; ++half) {
    for (size_t i = 0; i < kFeatureValues; ++i) {
      sums_[pixel].halves[half][i] += from.sums_[pixel].halves[half][i];
    }
    for (size_t i = 0; i < kSharedValues; i += 4) {
      Color4 more;
      std::memcpy(&more, &from.sums_[pixel].shared[half][i], sizeof more);
      add_finite(more, &sums_[pixel].shared[half][i]);
    }
  }
  if (!second_lights_.empty()) second_lights_.add_sums(from.second_lights_, pixel);
}

void HalfSums::archive(Archive& archive) {
  archive.values(std::span(sums_.begin(), sums_.size()));
  second_lights_.archive(archive);
  bool finite = true;
  for (const Sums& sums : sums_) {
    for (const auto& half : sums.halves) {
      for (const double value : half) finite &= std::isfinite(value);
    }
    for (const auto& half : sums.shared) {
      for (const float value : half) finite &= std::isfinite(value);
    }
  }
  archive.check(finite);
}

}  // namespace emberline
