#include "renderer/film/light_group_sums.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <limits>

#include "renderer/core/color4.h"
#include "renderer/film/light_group_values.h"
#include "renderer/film/light_mix.h"

namespace emberline {
namespace {

constexpr float kMost = std::numeric_limits<float>::max();

Color4 load4(const float* p) {
  Color4 four;
  std::memcpy(&four, p, sizeof(four));
  return four;
}

}  // namespace

void LightGroupSums::reset(size_t pixels) {
  // The last group of the last pixel is read four floats at a time.
  const size_t size = groups_ >= 0 ? pixels * stride() + 1 : 0;
  sums_.reset(size);
  rests_.reset(size);
}

void LightGroupSums::add_to(size_t at, float value) {
  float& sum = sums_[at];
  float& rest = rests_[at];
  // Knuth's exact sum (The Art of Computer Programming, volume 2, section 4.2.2, theorem B), and
  // Dekker's of a large and a small number: whatever they are, the pair holds their sum.
  const float rounded = sum + value;
  const float of_value = rounded - sum;
  const float left_out = (sum - (rounded - of_value)) + (value - of_value) + rest;
  const float total = rounded + left_out;
  if (!(std::abs(total) <= kMost)) {  // finite samples may add up to more than a float holds
    sum = std::clamp(rounded, -kMost, kMost);
    rest = 0.0f;
    return;
  }
  sum = total;
  rest = left_out - (total - rounded);
}

void LightGroupSums::add(size_t pixel, float filter_weight, float alpha,
                         const LightGroupValues& values, int lane) {
  const size_t first = pixel * stride();
  add_to(first, 1.0f);
  add_to(first + 1, alpha * filter_weight);
  values.for_each(lane, [&](size_t group, const Rgb& radiance) {
    const size_t at = first + 3 * (group + 1);
    for (int c = 0; c < 3; ++c) add_to(at + size_t(c), radiance[c] * filter_weight);
  });
}

void LightGroupSums::show(size_t pixel, std::span<const Rgb> means) {
  assert(means.size() == size_t(groups_) && sums_[pixel * stride()] == 0.0f);
  float* sums = &sums_[pixel * stride()];
  sums[0] = 1.0f;
  for (size_t g = 0; g < means.size(); ++g) std::copy_n(&means[g].x, 3, &sums[3 * (g + 1)]);
}

void LightGroupSums::copy(const LightGroupSums& from, size_t from_pixel, size_t pixel) {
  assert(from.groups_ == groups_);
  std::copy_n(&from.sums_[from_pixel * stride()], stride(), &sums_[pixel * stride()]);
  std::copy_n(&from.rests_[from_pixel * stride()], stride(), &rests_[pixel * stride()]);
}

Rgb LightGroupSums::mean(size_t pixel, int group) const {
  const auto sum = [&](size_t i) { return double(sums_[i]) + double(rests_[i]); };
  const size_t first = pixel * stride(), at = first + 3 * (size_t(group) + 1);
  const double samples = sum(first), scale = samples > 0 ? 1.0 / samples : 0.0;
  return {float(sum(at) * scale), float(sum(at + 1) * scale), float(sum(at + 2) * scale)};
}

void LightGroupSums::relit(size_t pixel, const LightMix& mix, float* rgba) const {
  assert(mix.size() == size_t(groups_));
  const float* sums = &sums_[pixel * stride()];
  const float scale = sums[0] > 0.0f ? 1.0f / sums[0] : 0.0f;
  const float alpha = std::clamp(sums[1] * scale, 0.0f, 1.0f);
  Color4 sum = splat4(0.0f);
  for (size_t group = 0; group < mix.size(); ++group) {
    sums += 3;
    // The fourth float is the next group's, and of no interest.
    sum += load4(sums) * splat4(scale) * mix.data()[group];
  }
  for (int c = 0; c < 3; ++c) rgba[c] = std::clamp(sum[c], -kMost, kMost);
  rgba[3] = alpha;
}

void LightGroupSums::prefetch(size_t pixel) const {
  constexpr size_t kLine = 64 / sizeof(float);
  const size_t first = pixel * stride();
  for (size_t i = 0; i < stride(); i += kLine) {
    __builtin_prefetch(&sums_[first + i], 1);
    __builtin_prefetch(&rests_[first + i], 1);
  }
}

}  // namespace emberline
