// Computes reference albedos of surfaces in a white furnace, by quadrature in double.
//
// The renderer's tables integrate over visible normals in float. Here microfacet normals are drawn
// from D cos (Walter et al. 2007, eq. 35), and normals that reflect below the surface are cut off
// at the exact edge, so that Gauss-Legendre converges. The two share only the lobe's formula, which
// is isotropic GGX with height-correlated Smith masking.
#pragma once

#include <algorithm>
#include <cmath>

#include "renderer/core/constants.h"
#include "renderer/core/vector.h"
#include "renderer/shading/gauss_legendre.h"

namespace emberline::test {

struct LobeIntegrals {
  double white = 0;    // E, with F = 1
  double schlick = 0;  // B, with F = (1 - wo.m)^5
  double fresnel = 0;  // with the exact F of a dielectric of index `eta`
  double height = 0;   // with F = 1, under radiance wi.z
};

inline double exact_fresnel(double cos_i, double eta) {
  const double sin2_t = (1 - cos_i * cos_i) / (eta * eta);
  if (sin2_t >= 1) return 1;
  const double cos_t = std::sqrt(1 - sin2_t);
  const double s = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
  const double p = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
  return (s * s + p * p) / 2;
}

// Returns the integrals of the reflection lobe at cosine mu. An alpha of 0 is a mirror. Doubling
// the panels changes the results by less than 1e-6 for every (alpha, mu) of the tests.
inline LobeIntegrals lobe_integrals(double mu, double alpha, double eta = 1.5, int panels = 16) {
  const auto weigh = [&](double d, double mu_i, double weight, LobeIntegrals* sum) {
    sum->height += weight * mu_i;
    sum->white += weight;
    sum->schlick += weight * std::pow(1 - d, 5);
    sum->fresnel += weight * exact_fresnel(std::min(1.0, d), eta);
  };
  LobeIntegrals sum;
  if (alpha == 0) {
    weigh(mu, mu, 1, &sum);
    return sum;
  }
  static const GaussLegendre<8> outer;
  static const GaussLegendre<32> inner;
  const double sin_o = std::sqrt((1 - mu) * (1 + mu));
  const auto lambda = [&](double c) {
    return 0.5 * (std::sqrt(1 + alpha * alpha * (1 / (c * c) - 1)) - 1);
  };
  // t is the fraction of normals within the tilt, with tan^2(tilt) = alpha^2 t / (1 - t). The
  // substitution 1 - t = (1 - v)^4 puts nodes into the long tail. Up to a tilt of (90 - theta_o) /
  // 2 degrees every azimuth reflects above the surface, and beyond (90 + theta_o) / 2 degrees none
  // does. The integral is cut at these two tilts.
  const auto share = [&](double tilt) {
    return 1 - std::pow(1 + square(std::tan(tilt) / alpha), -0.25);
  };
  const double theta_o = std::acos(mu);
  const double cuts[] = {0, share((kPiD / 2 - theta_o) / 2), share((kPiD / 2 + theta_o) / 2)};
  for (int part = 0; part < 2; ++part)
    for (int panel = 0; panel < panels; ++panel)
      for (size_t i = 0; i < 8; ++i) {
        // The map 3 y^2 - 2 y^3 clusters nodes at both cuts, where the azimuths vary like a square
        // root.
        const double y = (panel + outer.x[i]) / panels, length = cuts[part + 1] - cuts[part];
        const double v = cuts[part] + length * y * y * (3 - 2 * y);
        const double dt = outer.w[i] / panels * length * 6 * y * (1 - y) * 4 * std::pow(1 - v, 3);
        const double rest = std::pow(1 - v, 4);
        const double tan2 = alpha * alpha * (1 - rest) / rest, c = 1 / std::sqrt(1 + tan2);
        const double s = std::sqrt(tan2) * c;
        // Up to the azimuth `end`, wi.z = 2 (wo.m) c - mu > 0.
        double end = part == 0 ? kPiD : 0;
        if (part == 1 && sin_o * s > 0)
          end = std::acos(std::clamp((mu / (2 * c) - mu * c) / (sin_o * s), -1.0, 1.0));
        for (size_t j = 0; j < 32 && end > 0; ++j) {
          // The map phi = end (1 - x^2) clusters nodes at the edge, where the masking falls off
          // within alpha.
          const double x = inner.x[j], phi = end * (1 - x * x);
          const double d = mu * c + sin_o * s * std::cos(phi), mu_i = 2 * d * c - mu;
          if (mu_i <= 0) continue;
          const double g2 = 1 / (1 + lambda(mu) + lambda(mu_i));
          weigh(d, mu_i, d / (mu * c) * g2 * dt * inner.w[j] * 2 * x * end / kPiD, &sum);
        }
      }
  return sum;
}

// Returns 2 times the integral of lobe_integrals mu dmu. The substitution mu = t^3 puts nodes where
// a smooth surface loses energy.
inline LobeIntegrals average_lobe_integrals(double alpha) {
  static const GaussLegendre<48> rule;
  LobeIntegrals sum;
  for (size_t i = 0; i < 48; ++i) {
    const double t = rule.x[i], mu = t * t * t;
    const LobeIntegrals at = lobe_integrals(mu, alpha, 1.5, 8);
    const double weight = rule.w[i] * 2 * mu * 3 * t * t;
    sum.white += weight * at.white;
    sum.schlick += weight * at.schlick;
    sum.fresnel += weight * at.fresnel;
  }
  return sum;
}

// Returns the albedo with Schlick's Fresnel, F90 = 1, and Kulla & Conty's multiple scattering: F0 E
// + (1 - F0) B + Fms (1 - E), where Fms = F^2 Eavg / (1 - F (1 - Eavg)) and F = F0 + (1 - F0) / 21.
inline double compensated_albedo(double f0, const LobeIntegrals& at, const LobeIntegrals& average) {
  const double f = f0 + (1 - f0) / 21;
  const double multiple = f * f * average.white / (1 - f * (1 - average.white));
  return f0 * at.white + (1 - f0) * at.schlick + multiple * (1 - at.white);
}

// Returns the share of the light that a rough interface refracts to the far side, without the 1 /
// eta^2 of radiance. `eta` is the index beyond the interface divided by the index before it. The
// midpoint rule is within 1e-4, since halving n changes no value of the tests by more.
inline double refracted_share(double mu, double alpha, double eta, int n = 500) {
  const double sin_o = std::sqrt((1 - mu) * (1 + mu));
  const auto lambda = [&](double c) {
    return 0.5 * (std::sqrt(1 + alpha * alpha * (1 / (c * c) - 1)) - 1);
  };
  double sum = 0;
  for (int i = 0; i < n; ++i) {
    const double v = (i + 0.5) / n, rest = std::pow(1 - v, 4);
    const double tan2 = alpha * alpha * (1 - rest) / rest, c = 1 / std::sqrt(1 + tan2);
    const double s = std::sqrt(tan2) * c;
    for (int j = 0; j < n; ++j) {
      const double d = mu * c + sin_o * s * std::cos(kPiD * (j + 0.5) / n);
      if (d <= 0) continue;
      const double cos2_t = 1 - (1 - d * d) / (eta * eta);
      if (cos2_t <= 0) continue;
      const double below = mu / eta - (d / eta - std::sqrt(cos2_t)) * c;  // -wi.z
      if (below <= 0) continue;
      sum += (1 - exact_fresnel(d, eta)) * d / (mu * c) / (1 + lambda(mu) + lambda(below)) * 4 *
             std::pow(1 - v, 3);
    }
  }
  return sum / (double(n) * n);
}

}  // namespace emberline::test
