#include "renderer/reconstruction/regression.h"

#include <cmath>
#include <limits>

#include "renderer/reconstruction/patches.h"

namespace emberline {

constexpr int offset_x(int offset) { return offset % kWindow - kWindowRadius; }
constexpr int offset_y(int offset) { return offset / kWindow - kWindowRadius; }
constexpr int term(int row, int column) { return row * (row + 1) / 2 + column; }

// Ridges are added to the features' variances. This ridge is relative to the feature's variance in
// the window. It avoids extreme slopes if features are collinear.
constexpr float kRidge = 1e-3f;
// This ridge is relative to the feature's mean squared difference from its value at the pixel. It
// covers the rounding error where the variance is 0.
constexpr float kRoundingRidge = 1e-5f;
// This ridge is relative to the feature's noise. It limits the influence of features that vary by
// no more than their noise.
constexpr float kNoiseRidge = 4.0f;
// The minimum part of a feature's variance that is independent of the features before it, relative
// to the whole variance. A smaller part is only rounding error.
constexpr float kMinPivot = 1e-5f;
// A feature is ignored in windows where its spread(), or the spread() of its difference from a
// feature already chosen, is at most this.
constexpr float kMinSpread = 4e-6f;
constexpr float kMinDivisor = 1e-30f;
// A fit that gives its own pixel at least this weight does not determine a plane, and is replaced
// by the weighted mean. A weighted mean over a full window gives the pixel less than this.
constexpr float kMaxWeight = 1e6f;

WindowWeights::WindowWeights() : weights_(new Rows[2 * kOffsets]) {}

void WindowWeights::measure(const Halves& h, const Tile& tile) {
  for (size_t s = 0; s < 2; ++s) {
    const Half& half = h.half[s];
    for (int o = 0; o < kOffsets; ++o) {
      const int i = offset_x(o), j = offset_y(o);
      Rows& means = weights_[s * kOffsets + size_t(o)];
      patch_means<kPatchRadius>(
          tile.y,
          [&](int y, float* __restrict out) {
            const int x0 = tile.x - kPatchPad;
            float squared[kPatchRun] = {};
            for (const BorderedPlane& plane : half.colour) {
              const float *p = plane.clamped_row(y) + x0, *q = plane.clamped_row(y + j) + x0 + i;
              for (int x = 0; x < kPatchRun; ++x) {
                const float d = p[x] - q[x];
                squared[x] += d * d;
              }
            }
            const float *vp = half.noise.clamped_row(y) + x0,
                        *vq = half.noise.clamped_row(y + j) + x0 + i;
            for (int x = 0; x < kPatchRun; ++x) {
              const float v = vp[x] + vq[x];
              out[x] = (squared[x] - v) / (v + 1e-12f);
            }
          },
          means);
      for (int r = 0; r < kTileRows; ++r) {
        for (int x = 0; x < kRun; ++x) means[r][x] = exp_minus(std::max(means[r][x], 0.0f));
      }
    }
  }
}

void WindowFit::set_position(const Tile& tile, int column, int row) {
  column_ = column;
  row_ = row;
  x_ = tile.x + column;
  y_ = tile.y + row;
  first_ = std::max(kWindowRadius - y_, 0) * kWindow;
  last_ = std::min(kWindowRadius + halves_.height - y_, kWindow) * kWindow;
  choose_features();
  for (int k = 0; k < features(); ++k) load(feature(k, y_), center_[k]);
}

// Chooses the features that vary. On a plane, only depth varies in most windows, and each
// additional feature costs more than the one before.
void WindowFit::choose_features() {
  feature_count_ = 0;
  for (size_t k = 0; k < std::min(halves_.features.size(), size_t(kMaxFeatures)); ++k) {
    const Feature& feature = halves_.features[k];
    bool varies = spread(feature.value, nullptr) > kMinSpread;
    for (int l = 0; l < feature_count_; ++l)
      varies = varies && spread(feature.value, &features_[l]->value) > kMinSpread;
    if (varies) features_[feature_count_++] = &feature;
  }
}

// Returns the range of the values in the windows, divided by their largest magnitude. If `less` is
// not null, the range is that of the values' differences from `less`.
float WindowFit::spread(const BorderedPlane& of, const BorderedPlane* less) const {
  static_assert(kLanes >= 2 * kWindowRadius);  // so two loads per row cover all windows
  constexpr float kMaxFloat = std::numeric_limits<float>::max();
  Lanes minimum = all_lanes(kMaxFloat), maximum = all_lanes(-kMaxFloat), size = {};
  for (int y = y_ + offset_y(first_); y <= y_ + offset_y(last_ - 1); ++y) {
    for (const int i : {-kWindowRadius, kWindowRadius}) {
      Lanes value, other = {};
      load(of.row(y) + x_ + i, value);
      if (less != nullptr) load(less->row(y) + x_ + i, other);
      size = max_lanes(size, max_lanes(value, Lanes{} - value));
      value -= other;
      minimum = min_lanes(minimum, value);
      maximum = max_lanes(maximum, value);
    }
  }
  float lo = kMaxFloat, hi = -kMaxFloat, all = 0.0f;
  for (int x = 0; x < kLanes; ++x) {
    lo = std::min(lo, minimum[x]);
    hi = std::max(hi, maximum[x]);
    all = std::max(all, size[x]);
  }
  return all > 0 ? (hi - lo) / all : 0.0f;
}

void WindowFit::fit(const WindowWeights& similarity, size_t half, int bandwidth) {
  read_weights(similarity, half, bandwidth);
  const int terms = term(features(), features()) + 1;
  for (int k = 0; k < terms; ++k) moments_[k] = Lanes{};
  for (int o = first_; o < last_; o += kAtOnce) add_moments(o);
  subtract_means();
  decompose();
  fall_back_to_mean();
}

void WindowFit::read_weights(const WindowWeights& similarity, size_t half, int bandwidth) {
  Lanes inside;
  for (int x = 0; x < kLanes; ++x) inside[x] = x_ + x >= 0 && x_ + x < halves_.width ? 1.0f : 0.0f;
  for (int o = first_; o < last_; ++o) {
    Lanes w, known;
    load(similarity.of(1 - half, o, row_) + column_, w);
    load(halves_.half[half].known.row(y_ + offset_y(o)) + x_ + offset_x(o), known);
    for (int k = 0; k < bandwidth; ++k) {
      w *= w;
      w *= w;
    }
    weights_[o] = w * inside;
    known_weights_[o] = weights_[o] * known;
  }
}

void WindowFit::add_moments(int offset) {
  const Lanes* w = known_weights_ + offset;
  const int count = features(), y = y_ + offset_y(offset);
  Lanes f[kMaxFeatures][kAtOnce];
  moments_[0] += (w[0] + w[1]) + w[2];
  for (int k = 0; k < count; ++k) {
    const float* there = feature(k, y) + offset_x(offset);
    Lanes weighted[kAtOnce];
    for (int j = 0; j < kAtOnce; ++j) {
      load(there + j, f[k][j]);
      f[k][j] -= center_[k];
      weighted[j] = w[j] * f[k][j];
    }
    Lanes* moment = moments_ + term(k + 1, 0);
    moment[0] += (weighted[0] + weighted[1]) + weighted[2];
    for (int l = 0; l <= k; ++l) {
      moment[l + 1] += (weighted[0] * f[l][0] + weighted[1] * f[l][1]) + weighted[2] * f[l][2];
    }
  }
}

// Converts sums of products to covariances and adds the ridges to the variances.
void WindowFit::subtract_means() {
  total_ = moments_[0];
  for (int x = 0; x < kLanes; ++x) {
    inverse_total_[x] = total_[x] > 0 ? 1.0f / std::max(total_[x], kMinDivisor) : 0.0f;
  }
  for (int k = 0; k < features(); ++k) {
    Lanes* m = moments_ + term(k + 1, 0);
    mean_[k] = m[0] * inverse_total_;
    const Lanes square = m[k + 1];
    for (int l = 0; l <= k; ++l) m[l + 1] -= m[0] * mean_[l];
    Lanes noise;
    load(features_[k]->noise.row(y_) + x_, noise);
    m[k + 1] += kRidge * m[k + 1] + kRoundingRidge * square + kNoiseRidge * noise * total_ +
                all_lanes(kMinDivisor);
  }
}

// Computes the Cholesky decomposition, row by row. It is stored in place, except for the diagonal,
// whose inverses are stored in inverse_.
void WindowFit::decompose() {
  for (int k = 0; k < features(); ++k) {
    Lanes* m = moments_ + term(k + 1, 1);
    const Lanes whole = m[k];
    for (int l = 0; l <= k; ++l) {
      const Lanes* n = moments_ + term(l + 1, 1);
      for (int j = 0; j < l; ++j) m[l] -= m[j] * n[j];
      if (l < k) m[l] *= inverse_[l];
    }
    for (int x = 0; x < kLanes; ++x) {
      const float minimum = std::max(kMinPivot * whole[x], kMinDivisor);
      inverse_[k][x] = 1.0f / std::sqrt(std::max(m[k][x], minimum));
    }
  }
}

// If the features do not determine a plane, the fit becomes the weighted mean.
void WindowFit::fall_back_to_mean() {
  Lanes slopes[kMaxFeatures], own_weight = inverse_total_;
  for (int k = 0; k < features(); ++k) slopes[k] = mean_[k];
  solve(slopes);
  for (int k = 0; k < features(); ++k) own_weight += slopes[k] * mean_[k];
  for (int x = 0; x < kLanes; ++x) {
    if (std::abs(own_weight[x]) < kMaxWeight) continue;
    for (int k = 0; k < features(); ++k) inverse_[k][x] = mean_[k][x] = 0.0f;
    for (int k = 0; k < kMaxTerms; ++k) moments_[k][x] = 0.0f;
  }
}

void WindowFit::apply(const Picture& picture) {
  const int count = features();
  for (auto& channel : fit_) std::fill(channel, channel + count + 1, Lanes{});
  for (int o = first_; o < last_; o += kAtOnce) add_products(o, picture);
  for (auto& fit : fit_) {
    fit[0] *= inverse_total_;
    for (int k = 0; k < count; ++k) fit[k + 1] -= total_ * mean_[k] * fit[0];
    solve(fit + 1);
    for (int k = 0; k < count; ++k) fit[0] -= mean_[k] * fit[k + 1];
  }
}

void WindowFit::add_products(int offset, const Picture& picture) {
  const Lanes* w = known_weights_ + offset;
  const int count = features(), i = offset_x(offset), y = y_ + offset_y(offset);
  Lanes weighted[3][kAtOnce];
  for (size_t c = 0; c < 3; ++c) {
    for (int j = 0; j < kAtOnce; ++j) {
      load(picture[c]->row(y) + x_ + i + j, weighted[c][j]);
      weighted[c][j] *= w[j];
    }
    fit_[c][0] += (weighted[c][0] + weighted[c][1]) + weighted[c][2];
  }
  for (int k = 0; k < count; ++k) {
    Lanes f[kAtOnce];
    for (int j = 0; j < kAtOnce; ++j) {
      load(feature(k, y) + i + j, f[j]);
      f[j] -= center_[k];
    }
    for (size_t c = 0; c < 3; ++c) {
      fit_[c][k + 1] += (weighted[c][0] * f[0] + weighted[c][1] * f[1]) + weighted[c][2] * f[2];
    }
  }
}

// Converts covariances of features and values to slopes, using the decomposition C = L L^T.
void WindowFit::solve(Lanes* slopes) const {
  const int count = features();
  for (int k = 0; k < count; ++k) {
    for (int j = 0; j < k; ++j) slopes[k] -= moments_[term(k + 1, j + 1)] * slopes[j];
    slopes[k] *= inverse_[k];
  }
  for (int k = count - 1; k >= 0; --k) {
    for (int j = k + 1; j < count; ++j) slopes[k] -= moments_[term(j + 1, k + 1)] * slopes[j];
    slopes[k] *= inverse_[k];
  }
}

void WindowFit::add_to(ColourPlanes& sums, const BorderedPlane* factor) const {
  const int count = features();
  for (int o = first_; o < last_; ++o) {
    const int i = offset_x(o), y = y_ + offset_y(o);
    Lanes value[3] = {fit_[0][0], fit_[1][0], fit_[2][0]};
    for (int k = 0; k < count; ++k) {
      Lanes there;
      load(feature(k, y) + i, there);
      there -= center_[k];
      for (size_t c = 0; c < 3; ++c) value[c] += fit_[c][k + 1] * there;
    }
    Lanes weight = weights_[o];
    if (factor != nullptr) {
      Lanes more;
      load(factor->row(y) + x_ + i, more);
      weight *= more;
    }
    for (size_t c = 0; c < 3; ++c) {
      float* to = sums[c].row(y) + x_ + i;
      Lanes sum;
      load(to, sum);
      store(sum + weight * value[c], to);
    }
  }
}

void WindowFit::add_weights_to(BorderedPlane& sums) const {
  for (int o = first_; o < last_; ++o) {
    float* to = sums.row(y_ + offset_y(o)) + x_ + offset_x(o);
    Lanes sum;
    load(to, sum);
    store(sum + weights_[o], to);
  }
}

}  // namespace emberline
