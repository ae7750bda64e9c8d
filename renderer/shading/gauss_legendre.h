// Quadrature rules for tables that are built at run time.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "renderer/core/constants.h"

namespace emberline {

// The nodes and weights of Gauss-Legendre quadrature on [0, 1]. The constructor finds them by
// Newton iteration on the Legendre polynomial (Press et al. 2007, "Numerical Recipes", section
// 4.6).
template <int N>
struct GaussLegendre {
  std::array<double, N> x, w;
  GaussLegendre() {
    for (int i = 0; i < N; ++i) {
      double z = std::cos(kPiD * (i + 0.75) / (N + 0.5));
      double slope = 1;
      for (int iteration = 0; iteration < 20; ++iteration) {
        double p1 = 1, p2 = 0;
        for (int j = 0; j < N; ++j) {
          const double p3 = p2;
          p2 = p1;
          p1 = ((2 * j + 1) * z * p2 - j * p3) / (j + 1);
        }
        slope = N * (z * p1 - p2) / (z * z - 1);
        z -= p1 / slope;
      }
      x[size_t(i)] = 0.5 * (1 - z);
      w[size_t(i)] = 1 / ((1 - z * z) * slope * slope);
    }
  }
};

}  // namespace emberline
