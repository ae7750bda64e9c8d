// The power spectrum of point sets, for samplers whose papers promise one.
#pragma once

#include <cmath>
#include <complex>
#include <cstdint>
#include <numbers>
#include <vector>

#include "unit/sample_statistics.h"

namespace emberline {

// The mean over `pixels` pixels of |sum_k exp(-2 pi i (f . x_k))|^2 / count, at each frequency (fx,
// fy) in cycles per pixel. The x_k are the first `count` points of the pair at dimension
// `first_dimension` of slot 0. Independent points have 1 at all frequencies but 0. The relative
// deviation is 1 / sqrt(pixels).
inline std::vector<double> point_spectrum(const Sampler& sampler, int first_dimension,
                                          uint32_t count, uint32_t pixels,
                                          const std::vector<std::pair<int, int>>& frequencies) {
  std::vector<double> power(frequencies.size());
  for (uint32_t p = 0; p < pixels; ++p) {
    std::vector<std::complex<double>> sum(frequencies.size());
    for_each_sample(sampler, {p % 64, p / 64, 21}, 0, count, [&](uint32_t, const SlotNumbers& n) {
      for (size_t i = 0; i < frequencies.size(); ++i) {
        const auto [fx, fy] = frequencies[i];
        const double turns =
            fx * double(n.u[first_dimension]) + fy * double(n.u[first_dimension + 1]);
        sum[i] += std::polar(1.0, -2.0 * std::numbers::pi * turns);
      }
    });
    for (size_t i = 0; i < sum.size(); ++i) power[i] += std::norm(sum[i]) / count / pixels;
  }
  return power;
}

// The frequencies of a half plane from `low` to `high` cycles. The other half plane is its mirror
// image.
inline std::vector<std::pair<int, int>> frequency_ring(double low, double high) {
  std::vector<std::pair<int, int>> ring;
  const int reach = int(high) + 1;
  for (int fx = 0; fx <= reach; ++fx) {
    for (int fy = -reach; fy <= reach; ++fy) {
      const double f = std::hypot(fx, fy);
      if (f >= low && f <= high && (fx > 0 || fy > 0)) ring.emplace_back(fx, fy);
    }
  }
  return ring;
}

inline double average(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / double(values.size());
}

}  // namespace emberline
