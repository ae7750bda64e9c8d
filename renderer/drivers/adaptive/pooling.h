// Pooling over neighbours: for each pixel, a weighted sum over the 5 x 5 pixels around it. The
// weights are a Gaussian of sigma 1.2 pixels. They are separable, so rows are pooled across first
// and then down.
#pragma once

#include <array>
#include <span>

namespace emberline {

inline constexpr int kPoolRadius = 2;
// exp(-d^2 / (2 sigma^2)) for sigma = 1.2 pixels and d = 0, 1, 2 pixels.
inline constexpr float kPoolKernel[kPoolRadius + 1] = {1.0f, 0.706648f, 0.249352f};

// `in` must be readable kPoolRadius values before and after the row.
inline void pool_across(const float* in, int width, float* out) {
  for (int x = 0; x < width; ++x) {
    out[x] =
        kPoolKernel[2] * (in[x - 2] + in[x + 2]) + kPoolKernel[1] * (in[x - 1] + in[x + 1]) + in[x];
  }
}

inline void pool_down(const std::array<const float*, 2 * kPoolRadius + 1>& in, int width,
                      float* out) {
  const auto [a, b, c, d, e] = in;
  for (int x = 0; x < width; ++x) {
    out[x] = kPoolKernel[2] * (a[x] + e[x]) + kPoolKernel[1] * (b[x] + d[x]) + c[x];
  }
}

}  // namespace emberline
