// A reference for the reflection of a rough conductor with multiple scattering. It is a random walk
// on the Smith microsurface (Heitz, Hanika, d'Eon & Dachsbacher 2016, "Multiple-Scattering
// Microfacet BSDFs with the Smith Model", ACM TOG 35(4)) with isotropic GGX, in double precision.
// It uses no code of the renderer's lobes.
//
// A height is given as the fraction c of the surface that is lower (C1 in the paper). Light that
// starts at height c in direction d meets the next microfacet at the height c u^(-d.z / a). Here u
// is uniform in [0, 1), and a is the area of the microfacets that the light faces (section 4 of the
// paper, where Lambda is a / d.z). If the light goes up and u is below c^(a / d.z), it leaves the
// surface instead.
#pragma once

#include <algorithm>
#include <cmath>

#include "renderer/core/constants.h"
#include "renderer/core/vector.h"

namespace emberline::test {

class SmithWalk {
 public:
  // The Fresnel term is Schlick's: it is f0 at normal incidence and 1 at grazing angles.
  explicit SmithWalk(double alpha, double f0 = 1) : alpha2_(alpha * alpha), f0_(f0) {}

  // Returns the projected area of the microfacets visible from v, per area of the surface. v.z may
  // be negative.
  double visible_area(const Vec3d& v) const {
    const double slopes = alpha2_ * (v.x * v.x + v.y * v.y), root = std::sqrt(v.z * v.z + slopes);
    // Both terms have the same value, but each is free of cancellation only for its sign of v.z.
    return v.z >= 0 ? (root + v.z) / 2 : slopes / (2 * (root - v.z));
  }

  // Returns the phase function of a conductor (section 5.2). It is the density, per solid angle,
  // with which a microfacet that is visible from v reflects light towards w.
  double phase(const Vec3d& v, const Vec3d& w) const {
    const Vec3d h = v + w;
    if (h.z <= 0) return 0;
    const double xy2 = h.x * h.x + h.y * h.y, z2 = h.z * h.z;
    const double ratio = (xy2 + z2) / (xy2 / alpha2_ + z2);
    const double density = ratio * ratio / (kPiD * alpha2_) / (4 * visible_area(v));
    return density * fresnel(std::sqrt(xy2 + z2) / 2);
  }

  // Samples a direction w in proportion to phase() for a Fresnel term of 1. With alpha = 1, the
  // microfacets have the normals of a hemisphere. It reflects uniformly into the cap w.z > -v.z
  // (Dupuy & Benyoub 2023). With another alpha, the hemisphere is stretched. v may also come from
  // below.
  Vec3d sample_phase(const Vec3d& v, double u1, double u2) const {
    const double alpha = std::sqrt(alpha2_);
    const Vec3d s = unit(Vec3d(alpha * v.x, alpha * v.y, v.z));
    const double z = 1 - u1 * (1 + s.z), r = std::sqrt(std::max(0.0, 1 - z * z));
    const Vec3d h = s + Vec3d(r * std::cos(2 * kPiD * u2), r * std::sin(2 * kPiD * u2), z);
    const Vec3d m(alpha * h.x, alpha * h.y, h.z);
    return unit(m * (2 * dot(v, m) / dot(m, m)) - v);
  }

  // Returns the fraction of the light that leaves the surface if it starts at height c towards w,
  // where w.z > 0.
  double escape(double c, const Vec3d& w) const { return std::pow(c, visible_area(-w) / w.z); }

  // Returns f(wo, wi) wi.z for a single bounce, in closed form. Light from wo first meets the
  // surface at heights c with the density (a / wo.z) c^(a / wo.z - 1), where a is visible_area(wo).
  // The result is phase() times the mean of escape() over these heights.
  double single(const Vec3d& wo, const Vec3d& wi) const {
    const double in = visible_area(wo) / wo.z;
    return phase(wo, wi) * in / (in + visible_area(-wi) / wi.z);
  }

  // Simulates one walk of light that comes from wo (wo.z > 0). Calls visit(order, v, c, weight) at
  // each microfacet, where the light comes from v and is at height c. The sum over all visits of
  //   weight phase(v, wi) escape(c, wi)
  // has the expectation f(wo, wi) wi.z. The sum over the visits of one order has the expectation of
  // that order's part of f(wo, wi) wi.z. To estimate multiple scattering better, every walk meets a
  // second microfacet, and `weight` includes the probability of this.
  template <class Random, class Visit>
  void walk(const Vec3d& wo, Random& random, const Visit& visit) const {
    Vec3d d = -wo;
    double c = 1, weight = 1;
    for (int order = 1;; ++order) {
      const double leaves = d.z > 0 ? escape(c, d) : 0;
      double u = random.next_double();
      if (order == 2) {
        weight *= 1 - leaves;
        u = leaves + (1 - leaves) * u;
      }
      if (u <= leaves) return;
      c = std::min(1.0, c * std::pow(u, -d.z / visible_area(-d)));
      visit(order, -d, c, weight);
      const double u1 = random.next_double();
      const Vec3d next = sample_phase(-d, u1, random.next_double());
      weight *= fresnel(std::sqrt(std::max(0.0, (1 - dot(d, next)) / 2)));
      d = next;
    }
  }

 private:
  static Vec3d unit(const Vec3d& v) { return v / std::sqrt(dot(v, v)); }
  double fresnel(double cosine) const {
    return f0_ == 1 ? 1 : f0_ + (1 - f0_) * std::pow(1 - std::min(1.0, cosine), 5);
  }

  double alpha2_, f0_;
};

}  // namespace emberline::test
