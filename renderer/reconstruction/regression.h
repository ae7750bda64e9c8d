// The filter itself: a first-order regression over the features of a window, pixel by pixel
// (Bitterli et al. 2016), as weights for its pixels. They do not depend on what is filtered, so
// that pictures that add up still do.
#pragma once

#include <array>
#include <memory>
#include <span>

#include "renderer/reconstruction/halves.h"
#include "renderer/reconstruction/lanes.h"
#include "renderer/reconstruction/tiles.h"

namespace emberline {

inline constexpr int kWindowRadius = 7;
inline constexpr int kWindow = 2 * kWindowRadius + 1;
inline constexpr int kOffsets = kWindow * kWindow;
static_assert(kWindowRadius + kPatchPad <= kPad);

// The bandwidths of the weights that are tried, as powers of those of the widest: exp(-d),
// exp(-d)^4 has half the bandwidth (Bitterli et al.: k of 1 and .5).
inline constexpr int kBandwidths = 2;

// Each pixel's likeness to those of its window, in either half: exp(-d) of the patches.
class WindowWeights {
 public:
  WindowWeights();
  void measure(const Halves& halves, const Tile& tile);
  const float* of(size_t half, int offset, int row) const { return at(half, offset)[row]; }

 private:
  using Rows = float[kTileRows][kRun];
  Rows& at(size_t half, int offset) { return weights_[half * kOffsets + size_t(offset)]; }
  const Rows& at(size_t half, int offset) const {
    return weights_[half * kOffsets + size_t(offset)];
  }
  std::unique_ptr<Rows[]> weights_;  // [half][offset]
};

// Filters kLanes pixels of a row.
class PixelFilter {
 public:
  explicit PixelFilter(const Halves& halves) : halves_(halves) {}

  // The regression of one half's pixels around those of the tile that begin at (column, row) in it,
  // weighted by the other half's likeness.
  void fit(const WindowWeights& weights, size_t half, int bandwidth, const Tile& tile, int column,
           int row);

  // What it says of a picture of the same half, at those pixels.
  using Picture = std::array<const Plane*, 3>;
  void apply(const Picture& picture, float (*out)[kLanes]) const;

  // The weight that a pixel itself has among those of its window.
  void own_weight(float* out) const { store(constant_, out); }

 private:
  static constexpr int kMostFeatures = 12;
  static constexpr int kMostTerms = (kMostFeatures + 1) * (kMostFeatures + 2) / 2;
  static constexpr int kAtOnce = 3;  // offsets
  static_assert(kWindow % kAtOnce == 0);

  int features() const { return int(std::min(halves_.features.size(), size_t(kMostFeatures))); }
  const float* feature(int k, int y) const { return halves_.features[size_t(k)].value.row(y) + x_; }
  void read_weights(const WindowWeights& likeness, size_t half, int bandwidth, int column, int row);
  void add_moments(int offset);
  void take_means_out();
  void decompose();
  void solve();

  const Halves& halves_;
  int x_ = 0, y_ = 0;
  int first_ = 0, last_ = 0;   // offsets of the rows that there are
  Lanes weights_[kOffsets];    // of the pixels of the window
  Lanes moments_[kMostTerms];  // weighted products of features, their lower triangle
  Lanes constant_;             // the fit: a pixel's weight is w (constant + slopes * features)
  Lanes slopes_[kMostFeatures];
  Lanes mean_[kMostFeatures];     // weighted means of the features
  Lanes inverse_[kMostFeatures];  // of the decomposition's diagonal
};

}  // namespace emberline
