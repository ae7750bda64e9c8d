// The filter itself: a first-order regression over the features of each pixel's window (Bitterli et
// al. 2016). A fit says something of all pixels of its window, weighted as they are in it, and a
// pixel is the mean of what all fits say of it. Linear in what is filtered, so that pictures that
// add up still do.
#pragma once

#include <array>
#include <memory>

#include "renderer/reconstruction/halves.h"
#include "renderer/reconstruction/lanes.h"
#include "renderer/reconstruction/tiles.h"

namespace emberline {

inline constexpr int kWindowRadius = 4;
inline constexpr int kWindow = 2 * kWindowRadius + 1;
inline constexpr int kOffsets = kWindow * kWindow;
// So for_each_tile_apart() allows: a fit writes to its window.
static_assert(kTileRows >= 2 * kWindowRadius && kRun >= 2 * kWindowRadius);

// The bandwidths of the weights that are tried, as powers of those of the widest: exp(-d),
// exp(-d)^4 has half the bandwidth (Bitterli et al.: k of 1 and .5).
inline constexpr int kBandwidths = 2;

// Each pixel's likeness to those of its window, in either half: exp(-d) of the patches.
class WindowWeights {
 public:
  WindowWeights();
  void measure(const Halves& halves, const Tile& tile);
  const float* of(size_t half, int offset, int row) const {
    return weights_[half * kOffsets + size_t(offset)][row];
  }

 private:
  using Rows = float[kTileRows][kRun];
  std::unique_ptr<Rows[]> weights_;  // [half][offset]
};

// The fits around kLanes pixels of a row.
class WindowFit {
 public:
  explicit WindowFit(const Halves& halves) : halves_(halves) {}

  // Around the pixels of the tile that begin at the column.
  void set_place(const Tile& tile, int column, int row);
  // Of one half's pixels there, weighted by the other half's likeness.
  void fit(const WindowWeights& weights, size_t half, int bandwidth);

  // To a picture of the same half. add_to() adds what it says of the pixels of the window, times
  // their weights in the fit and `factor`, if any; add_weights_to() those weights.
  using Picture = std::array<const BorderedPlane*, 3>;
  void apply(const Picture& picture);
  void add_to(ColourPlanes& sums, const BorderedPlane* factor) const;
  void add_weights_to(BorderedPlane& sums) const;

 private:
  static constexpr int kMostFeatures = 12;
  static constexpr int kMostTerms = (kMostFeatures + 1) * (kMostFeatures + 2) / 2;
  static constexpr int kAtOnce = 3;  // offsets
  static_assert(kWindow % kAtOnce == 0);

  int features() const { return chosen_; }
  const float* feature(int k, int y) const { return features_[k]->value.row(y) + x_; }
  void choose_features();
  float spread(const BorderedPlane& of, const BorderedPlane* less) const;
  void read_weights(const WindowWeights& likeness, size_t half, int bandwidth);
  void add_moments(int offset);
  void add_products(int offset, const Picture& picture);
  void take_means_out();
  void decompose();
  void find_plane();
  void solve(Lanes* slopes) const;

  const Halves& halves_;
  int x_ = 0, y_ = 0;
  int column_ = 0, row_ = 0;  // in the tile
  int first_ = 0, last_ = 0;  // offsets of the rows that there are
  int chosen_ = 0;            // features that tell pixels of these windows apart
  const Feature* features_[kMostFeatures];
  Lanes weights_[kOffsets];        // of the pixels of the window
  Lanes known_weights_[kOffsets];  // 0 for those without samples
  Lanes moments_[kMostTerms];      // weighted products of features, their lower triangle
  Lanes total_;                    // of the weights
  Lanes inverse_total_;
  Lanes here_[kMostFeatures];     // the features of the pixel
  Lanes mean_[kMostFeatures];     // weighted means of the features, less those of the pixel
  Lanes inverse_[kMostFeatures];  // of the decomposition's diagonal
  // The fit of each channel: constant + slopes * (features - here). Before it is solved, sums of
  // products.
  Lanes fit_[3][kMostFeatures + 1];
};

}  // namespace emberline
