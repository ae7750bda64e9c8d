// More integrands with exact means for the convergence tests of samplers, and their error curves.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "renderer/statistics/integrands.h"
#include "unit/sample_statistics.h"

namespace emberline {

// Couples two pairs of the camera, neither of which is the pixel's.
inline double coupled_shuffled(const SlotNumbers& n) {
  const double x = n.u[4] - n.u[2], y = n.u[5] - n.u[3];
  return std::exp(-4.0 * (x * x + y * y));
}
inline double signs(const SlotNumbers& n) {
  return (n.u[0] < 0.5f) == (n.u[2] < 0.5f) ? 1.0 : -1.0;
}
// Like signs(), but at a scale that blocks of 8 do not resolve: the parity of the fourth binary
// digits.
inline double fine_signs(const SlotNumbers& n) {
  return ((int(n.u[0] * 16.0f) ^ int(n.u[2] * 16.0f)) & 1) == 0 ? 1.0 : -1.0;
}
// An edge within the pixel times the soft shadow of a light.
inline double edge_and_shadow(const SlotNumbers& n) {
  return n.u[1] < 0.3f + 0.37f * n.u[0] && n.u[2] + n.u[3] < 0.8f + 0.4f * n.u[0] ? 1.0 : 0.0;
}

// The integral over x of (0.3 + 0.37 x) * area(a + b < s) with s = 0.8 + 0.4 x. The area is s^2 / 2
// up to s = 1 (x = 1/2), and then 1 - (2 - s)^2 / 2. Simpson's rule is exact for cubics, piece by
// piece.
inline double edge_and_shadow_mean() {
  const auto f = [](double x) {
    const double s = 0.8 + 0.4 * x;
    return (0.3 + 0.37 * x) * (s <= 1.0 ? 0.5 * s * s : 1.0 - 0.5 * (2.0 - s) * (2.0 - s));
  };
  return (f(0.0) + 4 * f(0.25) + 2 * f(0.5) + 4 * f(0.75) + f(1.0)) / 12.0;
}

// The mean squared error of the mean after each count, over `seeds` pixels.
inline std::vector<double> error_curve(const Sampler& sampler, const Integrand& integrand,
                                       uint32_t seeds, const std::vector<uint32_t>& counts) {
  std::vector<double> error(counts.size());
  for (uint32_t s = 0; s < seeds; ++s) {
    double sum = 0;
    size_t next = 0;
    for_each_sample(sampler, {s, s / 7, 11}, 0, counts.back(),
                    [&](uint32_t k, const SlotNumbers& n) {
                      sum += integrand.value(n);
                      if (k + 1 == counts[next]) {
                        const double difference = sum / (k + 1) - integrand.mean;
                        error[next++] += difference * difference / seeds;
                      }
                    });
  }
  return error;
}

// The variance relative to the exact variance of independent samples. 10000 seeds determine the
// ratio to about 1.5 %.
inline double ratio_to_random(const Sampler& sampler, const Integrand& integrand, double variance,
                              uint32_t count) {
  return error_curve(sampler, integrand, 10000, {count})[0] * count / variance;
}

}  // namespace emberline
