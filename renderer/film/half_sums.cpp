#include "renderer/film/half_sums.h"

#include <cstring>
#include <limits>

#include "renderer/core/color4.h"
#include "renderer/film/finite_float.h"

namespace emberline {
namespace {

std::array<float, kFeatureValues> values_of(const DenoiserFeatures& features) {
  return {features.albedo.x, features.albedo.y, features.albedo.z, features.normal.x,
          features.normal.y, features.normal.z, features.nearness, features.visibility};
}

// Adds four values and clamps the sums to finite floats, so that no sum can become NaN.
void add_finite(Color4 more, float* sums) {
  constexpr float kMaxFloat = std::numeric_limits<float>::max();
  Color4 sum;
  std::memcpy(&sum, sums, sizeof sum);
  sum += more;
  sum = sum > kMaxFloat ? splat4(kMaxFloat) : sum;
  sum = sum < -kMaxFloat ? splat4(-kMaxFloat) : sum;
  std::memcpy(sums, &sum, sizeof sum);
}

}  // namespace

bool is_finite(const DenoiserFeatures& features) { return all_finite(values_of(features)); }

void HalfSums::add_features(int half, const DenoiserFeatures& more) {
  const std::array<float, kFeatureValues> values = values_of(more);
  for (size_t i = 0; i < kFeatureValues; ++i) features[half][i] += double(values[i]);
}

void HalfSums::add_shares(int half, const Rgb& radiance, const SampleShares& shares) {
  const Color4 value = color4(radiance, 1.0f);
  for (size_t k = 0; k < kSharedPixels; ++k) add_finite(value * shares[k], &shared[half][4 * k]);
}

void HalfSums::merge(const HalfSums& more) {
  for (int half = 0; half < 2; ++half) {
    for (size_t i = 0; i < kFeatureValues; ++i) features[half][i] += more.features[half][i];
    for (size_t i = 0; i < kSharedValues; i += 4) {
      Color4 of_more;
      std::memcpy(&of_more, &more.shared[half][i], sizeof of_more);
      add_finite(of_more, &shared[half][i]);
    }
  }
}

bool HalfSums::is_valid() const {
  return all_finite(features[0]) && all_finite(features[1]) && all_finite(shared[0]) &&
         all_finite(shared[1]);
}

}  // namespace emberline
