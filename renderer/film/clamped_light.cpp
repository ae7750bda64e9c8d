#include "renderer/film/clamped_light.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "renderer/core/archive.h"
#include "renderer/film/finite_float.h"

namespace emberline {
namespace {

// Largest sum, in units of unit(). A contribution at the clamping limit is 2^16 to 2^17 units, so
// 2^43 such contributions fit.
constexpr uint64_t kMaxUnits = uint64_t(1) << 60;

double luminance_of(const std::array<uint64_t, 3>& sum) {
  return 0.2126 * double(sum[0]) + 0.7152 * double(sum[1]) + 0.0722 * double(sum[2]);
}

}  // namespace

ClampedLight::ClampedLight(float limit, int groups)
    : limit_(limit), units_per_radiance_(1.0 / unit()), groups_(size_t(groups)) {
  assert(limit > 0.0f && std::isfinite(limit));
}

// Returns a power of two, so that only rounding to whole units loses precision.
double ClampedLight::unit() const { return std::ldexp(1.0, std::ilogb(limit_) - 16); }

void ClampedLight::add(Sum* sum, const Rgb& radiance) const {
  for (size_t c = 0; c < 3; ++c) {
    const double units = std::round(double(radiance[int(c)]) * units_per_radiance_);
    const double room = double(kMaxUnits - (*sum)[c]);
    (*sum)[c] += uint64_t(std::clamp(units, 0.0, room));
  }
}

void ClampedLight::add_removed(uint32_t group, const Rgb& radiance) {
  add(&removed_, radiance);
  if (!groups_.empty()) add(&groups_[group], radiance);
}

void ClampedLight::merge(const ClampedLight& other) {
  if (!other.clamps()) return;
  if (!clamps()) {
    *this = other;
    return;
  }
  assert(limit_ == other.limit_ && groups_.size() == other.groups_.size());
  const auto merge_sum = [](Sum& sum, const Sum& more) {
    for (size_t c = 0; c < 3; ++c) sum[c] = std::min(sum[c] + more[c], kMaxUnits);
  };
  merge_sum(removed_, other.removed_);
  merge_sum(remaining_, other.remaining_);
  for (size_t i = 0; i < groups_.size(); ++i) merge_sum(groups_[i], other.groups_[i]);
}

void ClampedLight::archive(Archive& archive) {
  const auto same = [&archive](auto value) {
    const auto own = value;
    archive.number(value, std::numeric_limits<decltype(value)>::lowest(),
                   std::numeric_limits<decltype(value)>::max());
    archive.check(value == own);
  };
  same(double(limit_));
  same(uint64_t(groups_.size()));
  if (!clamps()) return;
  const auto sum = [&archive](Sum& s) {
    for (uint64_t& units : s) archive.number(units, uint64_t(0), kMaxUnits);
  };
  sum(removed_);
  sum(remaining_);
  for (Sum& group : groups_) sum(group);
}

Rgb ClampedLight::mean(const Sum& sum, uint64_t samples) const {
  Rgb result(0.0f);
  if (samples == 0 || !clamps()) return result;
  for (size_t c = 0; c < 3; ++c) {
    result[int(c)] = to_finite_float(double(sum[c]) * unit() / double(samples));
  }
  return result;
}

double ClampedLight::fraction() const {
  const double removed = luminance_of(removed_), all = removed + luminance_of(remaining_);
  return all > 0.0 ? removed / all : 0.0;
}

}  // namespace emberline
