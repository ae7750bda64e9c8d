// The filter itself: a first-order regression over the features of each pixel's window (Bitterli et
// al. 2016). A fit predicts all pixels of its window, each with a weight, and a filtered pixel is
// the weighted mean of the predictions of all fits. The result is linear in the image, so filtered
// parts still add up to the filtered whole.
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
// for_each_tile_in_phases() requires this, since a fit writes to its whole window.
static_assert(kTileRows >= 2 * kWindowRadius && kRun >= 2 * kWindowRadius);

// Number of bandwidths of the weights. Narrower weights are powers of the widest weights: exp(-d)^4
// has half the bandwidth of exp(-d) (these correspond to k = 1 and k = 0.5 in Bitterli et al.).
inline constexpr int kBandwidths = 2;

// For each half, the similarity of each pixel of a tile to the pixels of its window: exp(-d), where
// d is the distance of the two patches.
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

  // Selects the kLanes pixels of the tile that begin at `column` in `row`.
  void set_position(const Tile& tile, int column, int row);
  // Prepares the fits of one half's pixels, weighted by the similarity in the other half.
  void fit(const WindowWeights& weights, size_t half, int bandwidth);

  // apply() fits an image of the same half. add_to() adds the predictions for the window's pixels
  // to `sums`, multiplied by the pixels' weights in the fit and by `factor`, unless `factor` is
  // null. add_weights_to() adds the weights alone.
  using Picture = std::array<const BorderedPlane*, 3>;
  void apply(const Picture& picture);
  void add_to(ColourPlanes& sums, const BorderedPlane* factor) const;
  void add_weights_to(BorderedPlane& sums) const;

 private:
  static constexpr int kMaxFeatures = 12;
  static constexpr int kMaxTerms = (kMaxFeatures + 1) * (kMaxFeatures + 2) / 2;
  static constexpr int kAtOnce = 3;  // offsets processed together
  static_assert(kWindow % kAtOnce == 0);

  int features() const { return feature_count_; }
  const float* feature(int k, int y) const { return features_[k]->value.row(y) + x_; }
  void choose_features();
  float spread(const BorderedPlane& of, const BorderedPlane* less) const;
  void read_weights(const WindowWeights& similarity, size_t half, int bandwidth);
  void add_moments(int offset);
  void add_products(int offset, const Picture& picture);
  void subtract_means();
  void decompose();
  void fall_back_to_mean();
  void solve(Lanes* slopes) const;

  const Halves& halves_;
  int x_ = 0, y_ = 0;
  int column_ = 0, row_ = 0;  // position in the tile
  int first_ = 0, last_ = 0;  // range of offsets whose rows are inside the image
  int feature_count_ = 0;     // number of features that vary in these windows
  const Feature* features_[kMaxFeatures];
  Lanes weights_[kOffsets];        // weights of the window's pixels
  Lanes known_weights_[kOffsets];  // the same, but 0 for pixels without samples
  Lanes moments_[kMaxTerms];       // weighted products of features, lower triangle
  Lanes total_;                    // sum of known_weights_
  Lanes inverse_total_;
  Lanes center_[kMaxFeatures];   // the pixel's own features
  Lanes mean_[kMaxFeatures];     // weighted means of the features, minus center_
  Lanes inverse_[kMaxFeatures];  // inverses of the decomposition's diagonal
  // The fit of each channel, constant + slopes * (features - center_). Until the fit is solved,
  // this array holds sums of products.
  Lanes fit_[3][kMaxFeatures + 1];
};

}  // namespace emberline
