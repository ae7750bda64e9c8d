#include "renderer/film/light_group_sums.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <limits>

#include "renderer/film/finite_float.h"
#include "renderer/film/light_group_values.h"
#include "renderer/film/light_mix.h"

namespace emberline {
namespace {

constexpr float kMaxFloat = std::numeric_limits<float>::max();

Color4 load4(const float* p) {
  Color4 four;
  std::memcpy(&four, p, sizeof(four));
  return four;
}

// These functions access only three floats. The fourth float may belong to the next pixel, which
// another thread may own.
Color4 load3(const float* p) { return Color4{p[0], p[1], p[2], 0.0f}; }
void store3(Color4 value, float* p) { std::memcpy(p, &value, 3 * sizeof(float)); }

}  // namespace

void LightGroupSums::add_to(size_t at, Color4 value) {
  const Color4 sum = load3(&sums_[at]);
  // First comes Knuth's exact sum of any two values (The Art of Computer Programming, volume 2,
  // section 4.2.2, theorem B), then Dekker's exact sum of a large and a small number.
  const Color4 rounded = sum + value;
  const Color4 of_value = rounded - sum;
  const Color4 roundoff =
      (sum - (rounded - of_value)) + (value - of_value) + load3(&remainders_[at]);
  Color4 total = rounded + roundoff;
  Color4 remainder = roundoff - (total - rounded);
  if (!(std::abs(total[0] + total[1] + total[2]) <= kMaxFloat)) [[unlikely]] {
    // Finite samples may add up to more than a float can hold.
    for (int c = 0; c < 3; ++c) {
      if (std::abs(total[c]) <= kMaxFloat) continue;
      total[c] = std::clamp(rounded[c], -kMaxFloat, kMaxFloat);
      remainder[c] = 0.0f;
    }
  }
  store3(total, &sums_[at]);
  store3(remainder, &remainders_[at]);
}

void LightGroupSums::add(float filter_weight, float alpha, const LightGroupValues* values,
                         int lane) {
  add_to(0, Color4{1.0f, alpha * filter_weight, 0.0f, 0.0f});
  if (!values) return;
  values->for_each(lane, [&](size_t group, const Rgb& radiance) {
    add_to(3 * (group + 1), color4(radiance * filter_weight));
  });
}

void LightGroupSums::set_override(std::span<const Rgb> means) {
  assert(means.size() == size_t(groups_) && sums_[0] == 0.0f);
  sums_[0] = 1.0f;
  for (size_t g = 0; g < means.size(); ++g) std::copy_n(&means[g].x, 3, &sums_[3 * (g + 1)]);
}

void LightGroupSums::merge(const LightGroupSums& more) {
  assert(more.groups_ == groups_);
  for (size_t at = 0; at < size(); at += 3) {
    add_to(at, load3(&more.remainders_[at]));
    add_to(at, load3(&more.sums_[at]));
  }
}

bool LightGroupSums::is_valid() const {
  return all_finite(sums_, size()) && all_finite(remainders_, size()) &&
         (sums_[0] == 0.0f || sums_[0] >= 1.0f);
}

std::array<double, 3> LightGroupSums::sum(int group) const {
  const size_t at = 3 * (size_t(group) + 1);
  return {compensated_sum(at), compensated_sum(at + 1), compensated_sum(at + 2)};
}

Rgb LightGroupSums::mean(int group) const {
  const double samples = compensated_sum(0), scale = samples > 0 ? 1.0 / samples : 0.0;
  const std::array<double, 3> total = sum(group);
  return {to_finite_float(total[0] * scale), to_finite_float(total[1] * scale),
          to_finite_float(total[2] * scale)};
}

void LightGroupSums::relight_pixel(const LightMix& mix, float* rgba) const {
  assert(mix.size() == size_t(groups_));
  const float* sums = sums_;
  const float scale = sums[0] > 0.0f ? 1.0f / sums[0] : 0.0f;
  const float alpha = std::clamp(sums[1] * scale, 0.0f, 1.0f);
  Color4 sum = splat4(0.0f);
  for (size_t group = 0; group < mix.size(); ++group) {
    sums += 3;
    // The fourth float belongs to the next group and is ignored.
    sum = fma(load4(sums) * splat4(scale), mix.data()[group], sum);
  }
  for (int c = 0; c < 3; ++c) rgba[c] = std::clamp(sum[c], -kMaxFloat, kMaxFloat);
  rgba[3] = alpha;
}

}  // namespace emberline
