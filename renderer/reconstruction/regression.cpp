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

void RunFilter::fit(const WindowWeights& likeness, size_t half, int bandwidth, const Tile& tile,
                    int row) {
  x_ = tile.x;
  y_ = tile.y + row;
  for (int k = 0; k < kMostTerms; ++k) std::fill(moments_[k], moments_[k] + kRun, 0.0f);
  for (int o = 0; o < kOffsets; ++o) {
    const int y = y_ + offset_y(o);
    Row& w = weights_[o];
    if (y < 0 || y >= halves_.height) {
      std::fill(w, w + kRun, 0.0f);
      continue;
    }
    const float* like = likeness.of(1 - half, o, row);
    const float* known = halves_.half[half].known.row(y) + x_ + offset_x(o);
    for (int x = 0; x < kRun; ++x) w[x] = like[x] * known[x];
    for (int k = 0; k < bandwidth; ++k) {
      for (int x = 0; x < kRun; ++x) w[x] = (w[x] * w[x]) * (w[x] * w[x]);
    }
    add_moments(o);
  }
  solve();
}

void RunFilter::add_moments(int offset) {
  const Row& w = weights_[offset];
  const int i = offset_x(offset), j = offset_y(offset);
  for (int x = 0; x < kRun; ++x) moments_[0][x] += w[x];
  const int count = int(features());
  Row features[kMostFeatures];
  for (int k = 0; k < count; ++k) {
    const Plane& plane = halves_.features[size_t(k)].value;
    const float *here = plane.row(y_) + x_, *there = plane.row(y_ + j) + x_ + i;
    Row& f = features[k];
    for (int x = 0; x < kRun; ++x) f[x] = there[x] - here[x];
    Row weighted;
    for (int x = 0; x < kRun; ++x) weighted[x] = w[x] * f[x];
    float(*moment)[kRun] = moments_ + term(k + 1, 0);
    for (int x = 0; x < kRun; ++x) moment[0][x] += weighted[x];
    for (int l = 0; l <= k; ++l) {
      const Row& g = features[l];
      float* __restrict m = moment[l + 1];
      for (int x = 0; x < kRun; ++x) m[x] += weighted[x] * g[x];
    }
  }
}

// From products to covariances, with their ridge.
void RunFilter::take_means_out() {
  const int count = int(features());
  const Row& total = moments_[0];
  for (int k = 0; k < count; ++k) {
    float(*m)[kRun] = moments_ + term(k + 1, 0);
    const Row& first = m[0];
    for (int x = 0; x < kRun; ++x) mean_[k][x] = first[x] / std::max(total[x], kLeast);
    for (int l = 0; l <= k; ++l) {
      const float squares_share = l == k ? kRoundingRidge : 0.0f, share = l == k ? kRidge : 0.0f;
      float* __restrict c = m[l + 1];
      for (int x = 0; x < kRun; ++x) {
        const float covariance = c[x] - first[x] * mean_[l][x];
        c[x] = covariance + share * covariance + squares_share * c[x];
      }
    }
    const float* noise = halves_.features[size_t(k)].noise.row(y_) + x_;
    for (int x = 0; x < kRun; ++x) m[k + 1][x] += kNoiseRidge * noise[x] * total[x] + kLeast;
  }
}

// Cholesky's, row by row, in place but for the diagonal.
void RunFilter::decompose() {
  const int count = int(features());
  for (int k = 0; k < count; ++k) {
    float(*m)[kRun] = moments_ + term(k + 1, 1);
    for (int l = 0; l <= k; ++l) {
      const float(*n)[kRun] = moments_ + term(l + 1, 1);
      float* __restrict c = m[l];
      for (int j = 0; j < l; ++j) {
        for (int x = 0; x < kRun; ++x) c[x] -= m[j][x] * n[j][x];
      }
      if (l < k) {
        for (int x = 0; x < kRun; ++x) c[x] *= inverse_[l][x];
      } else {
        for (int x = 0; x < kRun; ++x) inverse_[k][x] = 1.0f / std::sqrt(std::max(c[x], kLeast));
      }
    }
  }
}

// Least squares. The fit at the pixel, where all features are 0, is a linear function of the
// values: their mean + (0 - mean features)^T C^-1 (covariances of features and values).
void RunFilter::solve() {
  take_means_out();
  decompose();
  const int count = int(features());
  for (int k = 0; k < count; ++k) {  // L z = -mean
    for (int x = 0; x < kRun; ++x) slopes_[k][x] = -mean_[k][x];
    for (int j = 0; j < k; ++j) {
      const Row& l = moments_[term(k + 1, j + 1)];
      for (int x = 0; x < kRun; ++x) slopes_[k][x] -= l[x] * slopes_[j][x];
    }
    for (int x = 0; x < kRun; ++x) slopes_[k][x] *= inverse_[k][x];
  }
  for (int k = count - 1; k >= 0; --k) {  // L^T slopes = z
    for (int j = k + 1; j < count; ++j) {
      const Row& l = moments_[term(j + 1, k + 1)];
      for (int x = 0; x < kRun; ++x) slopes_[k][x] -= l[x] * slopes_[j][x];
    }
    for (int x = 0; x < kRun; ++x) slopes_[k][x] *= inverse_[k][x];
  }
  const Row& total = moments_[0];
  for (int x = 0; x < kRun; ++x) {
    const float mean = total[x] > 0 ? 1.0f / std::max(total[x], kLeast) : 0.0f;
    float constant = mean;
    for (int k = 0; k < count; ++k) constant -= slopes_[k][x] * mean_[k][x];
    // Where no plane can be laid through the features: the weighted mean.
    const bool usable = std::abs(constant) < kLargestWeight;
    constant_[size_t(x)] = usable ? constant : mean;
    for (int k = 0; k < count; ++k) slopes_[k][x] = usable ? slopes_[k][x] : 0.0f;
  }
}

void RunFilter::apply(std::span<const Plane* const> planes, std::array<float, kRun>* out) const {
  const int count = int(features());
  for (size_t p = 0; p < planes.size(); ++p) out[p].fill(0.0f);
  for (int o = 0; o < kOffsets; ++o) {
    const int i = offset_x(o), y = y_ + offset_y(o);
    if (y < 0 || y >= halves_.height) continue;
    Row weight;
    for (int x = 0; x < kRun; ++x) weight[x] = constant_[size_t(x)];
    for (int k = 0; k < count; ++k) {
      const Plane& plane = halves_.features[size_t(k)].value;
      const float *here = plane.row(y_) + x_, *there = plane.row(y) + x_ + i;
      for (int x = 0; x < kRun; ++x) weight[x] += slopes_[k][x] * (there[x] - here[x]);
    }
    for (int x = 0; x < kRun; ++x) weight[x] *= weights_[o][x];
    for (size_t p = 0; p < planes.size(); ++p) {
      const float* value = planes[p]->row(y) + x_ + i;
      float* __restrict sum = out[p].data();
      for (int x = 0; x < kRun; ++x) sum[x] += weight[x] * value[x];
    }
  }
}

}  // namespace emberline
