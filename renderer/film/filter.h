// Pixel reconstruction filters by importance sampling: the filter chooses the point, in or around
// the pixel, through which a sample's camera ray passes. No sample is splatted into neighbouring
// pixels. So a pixel has one owner, its estimate is unbiased (no ratio of sums), and the film needs
// no locks (Ernst, Stamminger & Greiner 2006, "Filter Importance Sampling", Symposium on
// Interactive Ray Tracing).
//
// Lengths are in pixels; offsets are from the pixel's centre, x to the right, y downwards.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "renderer/core/vector.h"
#include "renderer/film/sample_shares.h"

namespace emberline {

// A sample's position, and the factor for its radiance: sign(f) * integral |f| / integral f. The
// factor is 1 for filters without negative lobes, and its expectation is 1 for every filter.
struct FilterSample {
  Vec2f offset;
  float weight;
};

// A row of the table of filters, which create(), --help, error messages and tests use.
struct FilterEntry {
  std::string_view name;
  std::string_view summary;
  float default_radius;
  double (*profile)(double x);  // an even function on [-1, 1], in units of the radius; any scale
};
std::span<const FilterEntry> filter_table();

// A filter is immutable, so threads may share it. It takes about 4 KiB and allocates nothing. All
// filters are separable products f(x) f(y) with support [-radius, radius]^2.
class PixelFilter {
 public:
  // Throws UsageError for an unknown name (the message lists the valid names) or a radius outside
  // (0, kMaxRadius]. The default radius comes from the table.
  static PixelFilter create(std::string_view name, std::optional<float> radius = {});
  static constexpr float kMaxRadius = 32.0f;

  // Maps u in [0, 1)^2 to an offset in [-radius, radius]^2, increasing in each coordinate so that
  // stratified u stay stratified. The box of radius 0.5 gives exactly u - 0.5. Along each axis, the
  // density of offsets differs from |f| / integral |f| by at most 4e-5 of the peak, because |f| is
  // interpolated linearly between knots.
  FilterSample sample(const Vec2f& u) const;
  // Returns a sample's weights (its shares) for each of the 3 x 3 pixels around it. The receiving
  // pixel combines the samples of the 3 x 3 pixels around itself by the balance heuristic (Veach &
  // Guibas 1995): it sums, over these pixels, each pixel's mean of radiance x share. The
  // expectation of this sum is the receiving pixel's value, and the sum has less variance than the
  // mean of the pixel's own samples.
  SampleShares shares(const Vec2f& offset) const;
  float radius() const { return radius_; }

 private:
  // Must be a multiple of 7: Mitchell's profile changes sign at 4/7 of its radius, which must be a
  // knot.
  static constexpr int kBins = 252;
  static constexpr int kGuides = 1024;

  struct Coordinate {
    float x;
    float weight;
  };

  PixelFilter(const FilterEntry& entry, float radius);
  Coordinate sample_1d(float u) const;
  float value_1d(float x) const;  // f(x), not normalised
  std::array<float, 3> shares_1d(float x) const;

  float radius_;
  bool uniform_ = false;  // true for the box, which needs no table
  float weight_ = 1.0f;   // integral |f| / integral f, in one dimension
  // Tables for x from 0 to the radius: |f| at the knots (linear in between, with unit integral),
  // the CDF of |f|, the bins where quantile searches start, and the sign of f in each bin.
  std::array<float, kBins + 1> density_{};
  std::array<float, kBins + 1> cdf_{};
  std::array<uint8_t, kGuides> guide_{};
  std::array<int8_t, kBins> sign_{};
};

}  // namespace emberline
