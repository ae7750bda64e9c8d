// Pixel reconstruction filters by importance sampling: the filter chooses where in and around the
// pixel a sample's camera ray goes, and nothing is ever splatted into a neighbour. So a pixel has
// one owner, its estimate is unbiased (no ratio of sums), and the film needs no locks (Ernst,
// Stamminger & Greiner 2006, "Filter Importance Sampling", Symposium on Interactive Ray Tracing).
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

// Where to sample, and the factor that the sample's radiance is multiplied by before it is added:
// sign(f) * integral |f| / integral f. It is 1 for filters without negative lobes, and its
// expectation is 1 for every filter.
struct FilterSample {
  Vec2f offset;
  float weight;
};

// The table of filters: feeds create(), --help, the "valid names are" message and the tests.
struct FilterEntry {
  std::string_view name;
  std::string_view summary;
  float default_radius;
  double (*profile)(double x);  // even, on [-1, 1] with the radius as unit; any scale
};
std::span<const FilterEntry> filter_table();

// Immutable after creation, so it may be shared by all threads; about 4 KiB, no allocation. All
// filters are separable products f(x) f(y) with support [-radius, radius]^2.
class PixelFilter {
 public:
  // Throws UsageError for an unknown name (listing the valid ones) or a radius outside
  // (0, kMaxRadius]. Without a radius, the table's.
  static PixelFilter create(std::string_view name, std::optional<float> radius = {});
  static constexpr float kMaxRadius = 32.0f;

  // u in [0, 1)^2 to an offset in [-radius, radius]^2, increasing in each coordinate so that
  // stratified u stay stratified. The box of radius 0.5 gives exactly u - 0.5. The offsets' density
  // is |f| / integral |f|, along each axis within 4e-5 of its peak (|f| is linear between knots).
  FilterSample sample(const Vec2f& u) const;
  // How a sample at this offset counts for each of the 3 x 3 pixels around it, its density taken
  // for that of all samples which the nine pixels around each of them drew (the balance heuristic,
  // Veach & Guibas 1995): the sum over those pixels of radiance x share has each pixel's value as
  // its expectation, with less variance than the samples of the pixel alone.
  SampleShares shares(const Vec2f& offset) const;
  float radius() const { return radius_; }

 private:
  // A multiple of 7: Mitchell's profile changes sign at 4/7 of its radius, and a knot must lie
  // there.
  static constexpr int kBins = 252;
  static constexpr int kGuides = 1024;

  struct Coordinate {
    float x;
    float weight;
  };

  PixelFilter(const FilterEntry& entry, float radius);
  Coordinate sample_1d(float u) const;
  float value_1d(float x) const;  // of any scale
  std::array<float, 3> shares_1d(float x) const;

  float radius_;
  bool uniform_ = false;  // the box needs no table
  float weight_ = 1.0f;   // integral |f| / integral f in one dimension
  // Positive half, x from 0 to radius: |f| at the knots, linear in between, with unit integral;
  // its running integral; where the search for a quantile starts; the sign of f in each bin.
  std::array<float, kBins + 1> density_{};
  std::array<float, kBins + 1> cdf_{};
  std::array<uint8_t, kGuides> guide_{};
  std::array<int8_t, kBins> sign_{};
};

}  // namespace emberline
