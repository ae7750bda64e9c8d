// Computes the albedo of a GGX reflection lobe in another way than the renderer's tables. It
// integrates over microfacet normals with the density D cos (Walter et al. 2007, eq. 35 and 41),
// where the tables integrate over visible normals. It uses the midpoint rule in double precision.
#pragma once

#include <cmath>

#include "renderer/core/constants.h"
#include "renderer/core/vector.h"

namespace emberline::test {

struct GgxAlbedo {
  double e = 0;  // the albedo with a Fresnel term F = 1
  double b = 0;  // the albedo with F = (1 - wo.m)^5
};

inline GgxAlbedo ggx_albedo(const Vec3d& wo, double ax, double ay, int n) {
  const auto lambda = [&](const Vec3d& v) {
    const double slope2 = (square(ax * v.x) + square(ay * v.y)) / square(v.z);
    return 0.5 * (std::sqrt(1 + slope2) - 1);
  };
  const double lambda_o = lambda(wo);
  GgxAlbedo sum;
  for (int i = 0; i < n; ++i) {
    const double u = (i + 0.5) / n;
    // The map t = 1 - (1 - u)^4 puts more nodes into the long tail.
    const double rest = std::pow(1 - u, 4), t = 1 - rest, dt = 4 * std::pow(1 - u, 3);
    const double tan_unit = std::sqrt(t / rest);
    for (int j = 0; j < n; ++j) {
      const double phi = 2 * kPiD * (j + 0.5) / n;
      Vec3d m(ax * tan_unit * std::cos(phi), ay * tan_unit * std::sin(phi), 1);
      m /= std::sqrt(dot(m, m));
      const double d = dot(wo, m);
      const Vec3d wi = m * (2 * d) - wo;
      if (d <= 0 || wi.z <= 0) continue;
      const double weight = d / (wo.z * m.z) / (1 + lambda_o + lambda(wi)) * dt;
      sum.e += weight;
      sum.b += weight * std::pow(1 - d, 5);
    }
  }
  return {sum.e / (double(n) * n), sum.b / (double(n) * n)};
}

inline GgxAlbedo ggx_albedo(double mu, double alpha, int n = 700) {
  return ggx_albedo(Vec3d(std::sqrt(1 - mu * mu), 0, mu), alpha, alpha, n);
}

}  // namespace emberline::test
