#include "renderer/film/shadow_sums.h"

#include <algorithm>
#include <cmath>

#include "renderer/core/archive.h"
#include "renderer/film/finite_float.h"

namespace emberline {
namespace {

// 1 where there is nothing to be shadowed.
double ratio(double received, double unshadowed) {
  return unshadowed > 0.0 ? std::clamp(received / unshadowed, 0.0, 1.0) : 1.0;
}

double luminance_of(const double (&rgb)[3]) {
  return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}

}  // namespace

bool is_finite(const CatcherSample& sample) {
  return is_finite(sample.received) && is_finite(sample.unshadowed) &&
         std::isfinite(sample.catcher + sample.hidden + sample.background);
}

void ShadowSums::add(size_t pixel, float filter_weight, const CatcherSample& sample) {
  Sums& sums = sums_[pixel];
  for (int c = 0; c < 3; ++c) {
    sums.received[c] += double(sample.received[c] * filter_weight);
    sums.unshadowed[c] += double(sample.unshadowed[c] * filter_weight);
  }
  sums.catcher += double(sample.catcher * filter_weight);
  sums.hidden += double(sample.hidden * filter_weight);
  sums.background += double(sample.background * filter_weight);
}

void ShadowSums::add_sums(const ShadowSums& from, size_t pixel) {
  Sums& sums = sums_[pixel];
  const Sums& more = from.sums_[pixel];
  for (int c = 0; c < 3; ++c) {
    sums.received[c] += more.received[c];
    sums.unshadowed[c] += more.unshadowed[c];
  }
  sums.catcher += more.catcher;
  sums.hidden += more.hidden;
  sums.background += more.background;
}

void ShadowSums::copy(const ShadowSums& from, size_t from_pixel, size_t pixel) {
  sums_[pixel] = from.sums_[from_pixel];
}

Rgb ShadowSums::shadow(size_t pixel) const {
  const Sums& sums = sums_[pixel];
  const double shows = sums.catcher + sums.background;
  const double share = shows > 0.0 ? std::clamp(sums.catcher / shows, 0.0, 1.0) : 0.0;
  Rgb shadow;
  for (int c = 0; c < 3; ++c) {
    shadow[c] = to_finite_float(1.0 - share * (1.0 - ratio(sums.received[c], sums.unshadowed[c])));
  }
  return shadow;
}

double ShadowSums::alpha(size_t pixel) const {
  const Sums& sums = sums_[pixel];
  return sums.hidden * (1.0 - ratio(luminance_of(sums.received), luminance_of(sums.unshadowed)));
}

void ShadowSums::archive(Archive& archive) {
  archive.values(std::span(sums_.begin(), sums_.size()));
  if (!archive.loading()) return;
  bool sound = true;
  for (const Sums& sums : sums_) {
    for (const double v : sums.received) sound &= std::isfinite(v);
    for (const double v : sums.unshadowed) sound &= std::isfinite(v);
    sound &= std::isfinite(sums.catcher) && std::isfinite(sums.hidden);
    sound &= std::isfinite(sums.background);
  }
  archive.check(sound);
}

}  // namespace emberline
