#include "renderer/statistics/ssim.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <limits>

#include "renderer/statistics/row_sums.h"

namespace emberline {
namespace {

constexpr int kWindow = 11;
constexpr double kSigma = 1.5;
constexpr double kC1 = 0.01 * 0.01;  // (K1 L)^2 with range L = 1
constexpr double kC2 = 0.03 * 0.03;  // (K2 L)^2

// Returns the Gaussian weights around the middle of the window. Their sum is 1.
std::vector<double> window_weights(int length) {
  const int size = std::min(length, kWindow);
  std::vector<double> weights(static_cast<size_t>(size));
  double sum = 0;
  for (int i = 0; i < size; ++i) {
    const double x = i - 0.5 * (size - 1);
    weights[size_t(i)] = std::exp(-x * x / (2 * kSigma * kSigma));
    sum += weights[size_t(i)];
  }
  for (double& weight : weights) weight /= sum;
  return weights;
}

// The weighted means of a, b, a^2, b^2 and a b over a window. The last element is a sum that is
// positive if one of the window's pixels is masked.
using Moments = std::array<double, 6>;

double ssim_of(const Moments& m) {
  const double variance_a = std::max(0.0, m[2] - m[0] * m[0]);
  const double variance_b = std::max(0.0, m[3] - m[1] * m[1]);
  const double covariance = m[4] - m[0] * m[1];
  return (2 * m[0] * m[1] + kC1) * (2 * covariance + kC2) /
         ((m[0] * m[0] + m[1] * m[1] + kC1) * (variance_a + variance_b + kC2));
}

struct RowSum {
  double ssim = 0;
  uint64_t windows = 0;
  RowSum& operator+=(const RowSum& other) {
    ssim += other.ssim;
    windows += other.windows;
    return *this;
  }
};

}  // namespace

double mean_ssim(const std::vector<float>& a, const std::vector<float>& b,
                 const std::vector<uint8_t>& masked, int width, int height) {
  [[maybe_unused]] const size_t pixels = size_t(width) * size_t(height);
  assert(pixels > 0 && a.size() == pixels && b.size() == pixels && masked.size() == pixels);
  const std::vector<double> wx = window_weights(width), wy = window_weights(height);

  const auto row_of_windows = [&](int top) {
    // Filters first along columns, then along rows, because the Gaussian window is separable.
    std::vector<Moments> columns(size_t(width), Moments{});
    for (size_t j = 0; j < wy.size(); ++j) {
      const size_t start = (size_t(top) + j) * size_t(width);
      for (size_t x = 0; x < size_t(width); ++x) {
        const double p = double(a[start + x]), q = double(b[start + x]);
        Moments& m = columns[x];
        m[0] += wy[j] * p;
        m[1] += wy[j] * q;
        m[2] += wy[j] * p * p;
        m[3] += wy[j] * q * q;
        m[4] += wy[j] * p * q;
        m[5] += masked[start + x] ? 1.0 : 0.0;
      }
    }
    RowSum sum;
    for (size_t left = 0; left + wx.size() <= size_t(width); ++left) {
      Moments m = {};
      for (size_t i = 0; i < wx.size(); ++i) {
        for (size_t k = 0; k < m.size(); ++k) m[k] += wx[i] * columns[left + i][k];
      }
      if (m[5] > 0) continue;
      sum.ssim += ssim_of(m);
      ++sum.windows;
    }
    return sum;
  };
  const RowSum total = sum_rows<RowSum>(height - int(wy.size()) + 1, row_of_windows);
  if (total.windows == 0) return std::numeric_limits<double>::quiet_NaN();
  return total.ssim / double(total.windows);
}

}  // namespace emberline
