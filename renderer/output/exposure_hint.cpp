#include "renderer/output/exposure_hint.h"

#include <algorithm>
#include <cmath>

#include "renderer/core/vector.h"

namespace emberline {
namespace {

// Returns the lowest power of two that is displayed as white; 0 if there is none.
float white_level(const DisplayTransform& transform) {
  constexpr int kMaxStops = 64;                    // the limit of `exposure`
  constexpr float kAlmostWhite = 254.5f / 255.0f;  // rounds to 255
  for (int stops = -kMaxStops; stops <= kMaxStops; ++stops) {
    const float grey = std::ldexp(1.0f, stops);
    float rgb[3] = {grey, grey, grey};
    transform.apply(rgb, 1);
    if (*std::ranges::min_element(rgb) >= kAlmostWhite) return grey;
  }
  return 0;
}

}  // namespace

ExposureHint::ExposureHint(const DisplayTransform& transform, float exposure)
    : exposure_(exposure), white_(white_level(transform)) {}

void ExposureHint::add(std::span<const float> rgba) {
  // With this tolerance, a plain white background does not count as brighter than white.
  constexpr float kTolerance = 1.001f;
  if (white_ <= 0) return;
  std::array<uint64_t, kBins> counts{};
  for (size_t i = 0; i + 3 < rgba.size(); i += 4) {
    if (rgba[i + 3] <= 0) continue;
    const float ratio = luminance(Rgb(rgba[i], rgba[i + 1], rgba[i + 2])) / white_;
    const bool brighter = ratio > kTolerance && std::isfinite(ratio);
    ++counts[brighter ? std::min(size_t(std::ilogb(ratio)) + 1, kBins - 1) : 0];
  }
  for (size_t bin = 0; bin < kBins; ++bin) {
    if (counts[bin] > 0) pixels_[bin].fetch_add(counts[bin], std::memory_order_relaxed);
  }
}

std::optional<int> ExposureHint::suggestion() const {
  uint64_t total = 0;
  for (const auto& count : pixels_) total += count;
  uint64_t below = pixels_[0];
  if (2 * below >= total) return std::nullopt;
  int stops = 0;  // the median is less than this many stops above white
  while (2 * below <= total) below += pixels_[size_t(++stops)];
  constexpr int kGreyStops = 2;  // middle grey, 0.18, is two to three stops below white
  constexpr int kMinExposure = -64;
  return std::max(int(std::floor(exposure_)) - stops - kGreyStops, kMinExposure);
}

}  // namespace emberline
