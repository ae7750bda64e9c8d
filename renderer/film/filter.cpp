#include "renderer/film/filter.h"

#include <cmath>
#include <string>

#include "renderer/core/constants.h"
#include "renderer/core/errors.h"
#include "renderer/core/names.h"

namespace emberline {
namespace {

double box(double) { return 1.0; }

// A Gaussian with sigma = radius / 3, minus its value at the edge so that it ends at zero. This is
// pbrt-v4's Gaussian with its defaults (radius 1.5, sigma 0.5).
double gaussian(double x) { return std::exp(-4.5 * x * x) - std::exp(-4.5); }

// The minimum four-term window of F. J. Harris 1978, "On the Use of Windows for Harmonic Analysis
// with the Discrete Fourier Transform", Proceedings of the IEEE 66(1), table on page 65. The window
// is shifted so that its peak is at 0.
double blackman_harris(double x) {
  const double t = kPiD * x;
  return 0.35875 + 0.48829 * std::cos(t) + 0.14128 * std::cos(2 * t) + 0.01168 * std::cos(3 * t);
}

// Mitchell & Netravali 1988, "Reconstruction Filters in Computer Graphics", SIGGRAPH, equation 8
// with B = C = 1/3. The paper's domain is [-2, 2]. The filter is negative beyond t = 8/7, because
// the outer piece equals -7/18 (2 - t)^2 (t - 8/7).
double mitchell(double x) {
  const double t = 2.0 * std::abs(x);
  if (t < 1.0) return (7.0 * t * t * t - 12.0 * t * t + 16.0 / 3.0) / 6.0;
  return -7.0 / 18.0 * (2.0 - t) * (2.0 - t) * (t - 8.0 / 7.0);
}

// The radii follow production renderers: Blackman-Harris spans three pixels, as in Cycles, whose
// setting of 1.5 px is half the span; the Gaussian and Mitchell have pbrt-v4's radii.
constexpr FilterEntry kFilters[] = {
    {"box",
     "the square of the pixel: the sharpest filter without ringing, but also the one with the most "
     "aliasing",
     0.5f, box},
    {"gaussian", "soft; sigma is a third of the radius", 1.5f, gaussian},
    {"blackman-harris", "close to the Gaussian, a little sharper for its radius", 1.5f,
     blackman_harris},
    {"mitchell", "sharp, with negative lobes (slight ringing, more noise)", 2.0f, mitchell},
};

}  // namespace

std::span<const FilterEntry> filter_table() { return kFilters; }

PixelFilter PixelFilter::create(std::string_view name, std::optional<float> chosen) {
  const FilterEntry& entry = find_named(kFilters, "`filter`", "filter", name);
  const float radius = chosen.value_or(entry.default_radius);
  if (!(radius > 0.0f && radius <= kMaxRadius)) {
    throw UsageError("`filter-radius`: " + std::to_string(radius) +
                     " is out of range; give a radius in pixels above 0 and up to " +
                     std::to_string(int(kMaxRadius)));
  }
  return PixelFilter(entry, radius);
}

PixelFilter::PixelFilter(const FilterEntry& entry, float radius)
    : radius_(radius), uniform_(entry.profile == box) {
  if (uniform_) return;
  double magnitude[kBins + 1];
  const double negligible = 1e-12 * entry.profile(0.0);
  for (int i = 0; i <= kBins; ++i) {
    const double f = entry.profile(double(i) / kBins);
    magnitude[i] = std::abs(f) < negligible ? 0.0 : std::abs(f);
  }
  // Integrates |f| with the trapezoidal rule. A bin's sign is the sign of the profile in the middle
  // of the bin.
  double cdf[kBins + 1] = {};
  double signed_sum = 0.0;
  for (int i = 0; i < kBins; ++i) {
    const double mass = 0.5 * (magnitude[i] + magnitude[i + 1]);
    sign_[i] = entry.profile((i + 0.5) / kBins) < 0.0 ? int8_t(-1) : int8_t(1);
    cdf[i + 1] = cdf[i] + mass;
    signed_sum += sign_[i] * mass;
  }
  const double total = cdf[kBins];
  weight_ = float(total / signed_sum);
  const double bin_width = double(radius) / kBins;
  for (int i = 0; i <= kBins; ++i) {
    cdf_[i] = float(cdf[i] / total);
    density_[i] = float(magnitude[i] / (total * bin_width));
  }
  int bin = 0;
  for (int g = 0; g < kGuides; ++g) {
    while (bin + 1 < kBins && cdf_[bin + 1] <= float(g) / kGuides) ++bin;
    guide_[g] = uint8_t(bin);
  }
}

PixelFilter::Coordinate PixelFilter::sample_1d(float u) const {
  // The subtraction is exact, because samplers return multiples of 2^-24.
  const float t = std::abs(2.0f * u - 1.0f);
  int bin = guide_[std::min(int(t * kGuides), kGuides - 1)];
  while (bin + 1 < kBins && cdf_[bin + 1] <= t) ++bin;
  const float mass = cdf_[bin + 1] - cdf_[bin];
  const float share = mass > 0.0f ? std::min((t - cdf_[bin]) / mass, 1.0f) : 1.0f;
  // Solves a0 s + (a1 - a0) s^2 / 2 = share (a0 + a1) / 2 for s without cancellation. The divisor
  // is zero only at the lower end of a bin that rises from zero, where s is 0.
  const float a0 = density_[bin], a1 = density_[bin + 1];
  const float divisor = a0 + std::sqrt(lerp(a0 * a0, a1 * a1, share));
  const float s = divisor > 0.0f ? std::min(share * (a0 + a1) / divisor, 1.0f) : 0.0f;
  const float x = radius_ * ((float(bin) + s) / float(kBins));
  return {std::copysign(x, u - 0.5f), float(sign_[bin]) * weight_};
}

float PixelFilter::value_1d(float x) const {
  const float t = std::abs(x) / radius_;
  if (t >= 1.0f) return 0.0f;
  if (uniform_) return 1.0f;
  const int bin = std::min(int(t * kBins), kBins - 1);
  return float(sign_[bin]) * lerp(density_[bin], density_[bin + 1], t * kBins - float(bin));
}

std::array<float, 3> PixelFilter::shares_1d(float x) const {
  float f[5];
  for (int i = 0; i < 5; ++i) f[i] = value_1d(x - float(i - 2));
  std::array<float, 3> shares;
  for (int d = 0; d < 3; ++d) {
    const float drawn = std::abs(f[d]) + std::abs(f[d + 1]) + std::abs(f[d + 2]);
    shares[d] = drawn > 0.0f ? weight_ * f[d + 1] / drawn : 0.0f;
  }
  return shares;
}

SampleShares PixelFilter::shares(const Vec2f& offset) const {
  const std::array<float, 3> across = shares_1d(offset.x), down = shares_1d(offset.y);
  SampleShares shares;
  for (size_t k = 0; k < kSharedPixels; ++k) shares[k] = across[k % 3] * down[k / 3];
  return shares;
}

FilterSample PixelFilter::sample(const Vec2f& u) const {
  if (uniform_) {
    const float width = 2.0f * radius_;
    return {Vec2f((u.x - 0.5f) * width, (u.y - 0.5f) * width), 1.0f};
  }
  const Coordinate x = sample_1d(u.x);
  const Coordinate y = sample_1d(u.y);
  return {Vec2f(x.x, y.x), x.weight * y.weight};
}

}  // namespace emberline
