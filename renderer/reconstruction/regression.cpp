#include "renderer/reconstruction/regression.h"

#include <cmath>

namespace emberline {
namespace {

constexpr int offset_x(int offset) { return offset % kWindow - kWindowRadius; }
constexpr int offset_y(int offset) { return offset / kWindow - kWindowRadius; }
constexpr int term(int row, int column) { return row * (row + 1) / 2 + column; }

// Of a feature's own spread in the window: keeps the fit from extremes where features say the same.
constexpr float kRidge = 1e-3f;
// Of its squared distance from the pixel: what rounding leaves of no spread at all.
constexpr float kRoundingRidge = 1e-5f;
// Of its noise: with so many times the noise as ridge, a feature that varies by no more than its
// noise has little to say.
constexpr float kNoiseRidge = 4.0f;
constexpr float kLeast = 1e-30f;        // divisor
constexpr float kLargestWeight = 1e6f;  // of a pixel; a mean of as many as a window has needs less

}  // namespace

WindowWeights::WindowWeights() : weights_(new Rows[2 * kOffsets]) {}

void WindowWeights::measure(const Halves& h, const Tile& tile) {
  for (size_t s = 0; s < 2; ++s) {
    const Half& half = h.half[s];
    for (int o = 0; o < kOffsets; ++o) {
      const int i = offset_x(o), j = offset_y(o);
      Rows& means = at(s, o);
      patch_means<kPatchRadius>(
          tile.y,
          [&](int y, float* __restrict out) {
            const int x0 = tile.x - kPatchPad;
            float squared[kPatchRun] = {};
            for (const Plane& plane : half.colour) {
              const float *p = plane.near(y) + x0, *q = plane.near(y + j) + x0 + i;
              for (int x = 0; x < kPatchRun; ++x) {
                const float d = p[x] - q[x];
                squared[x] += d * d;
              }
            }
            const float *vp = half.noise.near(y) + x0, *vq = half.noise.near(y + j) + x0 + i;
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

void PixelFilter::fit(const WindowWeights& likeness, size_t half, int bandwidth, const Tile& tile,
                      int column, int row) {
  x_ = tile.x + column;
  y_ = tile.y + row;
  first_ = std::max(kWindowRadius - y_, 0) * kWindow;
  last_ = std::min(kWindowRadius + halves_.height - y_, kWindow) * kWindow;
  read_weights(likeness, half, bandwidth, column, row);
  const int terms = term(features(), features()) + 1;
  for (int k = 0; k < terms; ++k) moments_[k] = Lanes{};
  for (int o = first_; o < last_; o += kAtOnce) add_moments(o);
  solve();
}

void PixelFilter::read_weights(const WindowWeights& likeness, size_t half, int bandwidth,
                               int column, int row) {
  for (int o = first_; o < last_; ++o) {
    Lanes w, known;
    load(likeness.of(1 - half, o, row) + column, w);
    load(halves_.half[half].known.row(y_ + offset_y(o)) + x_ + offset_x(o), known);
    for (int k = 0; k < bandwidth; ++k) {
      w *= w;
      w *= w;
    }
    weights_[o] = w * known;
  }
}

void PixelFilter::add_moments(int offset) {
  const Lanes* w = weights_ + offset;
  const int count = features(), y = y_ + offset_y(offset);
  Lanes f[kMostFeatures][kAtOnce];
  moments_[0] += (w[0] + w[1]) + w[2];
  for (int k = 0; k < count; ++k) {
    const float* there = feature(k, y) + offset_x(offset);
    Lanes here, weighted[kAtOnce];
    load(feature(k, y_), here);
    for (int j = 0; j < kAtOnce; ++j) {
      load(there + j, f[k][j]);
      f[k][j] -= here;
      weighted[j] = w[j] * f[k][j];
    }
    Lanes* moment = moments_ + term(k + 1, 0);
    moment[0] += (weighted[0] + weighted[1]) + weighted[2];
    for (int l = 0; l <= k; ++l) {
      moment[l + 1] += (weighted[0] * f[l][0] + weighted[1] * f[l][1]) + weighted[2] * f[l][2];
    }
  }
}

// From products to covariances, with their ridge.
void PixelFilter::take_means_out() {
  const Lanes total = moments_[0];
  Lanes divisor = total;
  for (int x = 0; x < kLanes; ++x) divisor[x] = std::max(divisor[x], kLeast);
  for (int k = 0; k < features(); ++k) {
    Lanes* m = moments_ + term(k + 1, 0);
    mean_[k] = m[0] / divisor;
    const Lanes square = m[k + 1];
    for (int l = 0; l <= k; ++l) m[l + 1] -= m[0] * mean_[l];
    Lanes noise;
    load(halves_.features[size_t(k)].noise.row(y_) + x_, noise);
    m[k + 1] += kRidge * m[k + 1] + kRoundingRidge * square + kNoiseRidge * noise * total + kLeast;
  }
}

// Cholesky's, row by row, in place but for the diagonal.
void PixelFilter::decompose() {
  for (int k = 0; k < features(); ++k) {
    Lanes* m = moments_ + term(k + 1, 1);
    for (int l = 0; l <= k; ++l) {
      const Lanes* n = moments_ + term(l + 1, 1);
      for (int j = 0; j < l; ++j) m[l] -= m[j] * n[j];
      if (l < k) m[l] *= inverse_[l];
    }
    for (int x = 0; x < kLanes; ++x) inverse_[k][x] = 1.0f / std::sqrt(std::max(m[k][x], kLeast));
  }
}

// Least squares. The fit at the pixel, where all features are 0, is a linear function of the
// values: their mean + (0 - mean features)^T C^-1 (covariances of features and values).
void PixelFilter::solve() {
  take_means_out();
  decompose();
  const int count = features();
  for (int k = 0; k < count; ++k) {  // L z = -mean
    slopes_[k] = -mean_[k];
    for (int j = 0; j < k; ++j) slopes_[k] -= moments_[term(k + 1, j + 1)] * slopes_[j];
    slopes_[k] *= inverse_[k];
  }
  for (int k = count - 1; k >= 0; --k) {  // L^T slopes = z
    for (int j = k + 1; j < count; ++j) slopes_[k] -= moments_[term(j + 1, k + 1)] * slopes_[j];
    slopes_[k] *= inverse_[k];
  }
  const Lanes total = moments_[0];
  Lanes mean;
  for (int x = 0; x < kLanes; ++x)
    mean[x] = total[x] > 0 ? 1.0f / std::max(total[x], kLeast) : 0.0f;
  constant_ = mean;
  for (int k = 0; k < count; ++k) constant_ -= slopes_[k] * mean_[k];
  for (int x = 0; x < kLanes; ++x) {
    // Where no plane can be laid through the features: the weighted mean.
    if (std::abs(constant_[x]) < kLargestWeight) continue;
    constant_[x] = mean[x];
    for (int k = 0; k < count; ++k) slopes_[k][x] = 0.0f;
  }
}

void PixelFilter::apply(const Picture& picture, float (*out)[kLanes]) const {
  const int count = features();
  Lanes here[kMostFeatures];
  for (int k = 0; k < count; ++k) load(feature(k, y_), here[k]);
  Lanes sum[3] = {};
  for (int o = first_; o < last_; ++o) {
    const int i = offset_x(o), y = y_ + offset_y(o);
    Lanes weight = constant_;
    for (int k = 0; k < count; ++k) {
      Lanes there;
      load(feature(k, y) + i, there);
      weight += slopes_[k] * (there - here[k]);
    }
    weight *= weights_[o];
    for (size_t c = 0; c < 3; ++c) {
      Lanes value;
      load(picture[c]->row(y) + x_ + i, value);
      sum[c] += weight * value;
    }
  }
  for (size_t c = 0; c < 3; ++c) store(sum[c], out[c]);
}

}  // namespace emberline
