// The anisotropic GGX reflection lobe (KHR_materials_anisotropy) for one wo, and its directional
// albedo. The lobe has alpha_x along local x, alpha_y along local y, and height-correlated Smith
// masking (Heitz 2014, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs").
//
// The sampling map, density, bounds and numerics generalise those of ggx.h; the bound on the cap
// uses the smaller alpha, as in Eto & Tokuyoshi 2023.
#pragma once

#include <cmath>

#include "renderer/core/branch_free.h"
#include "renderer/core/constants.h"
#include "renderer/core/vector.h"
#include "renderer/shading/lobes/ggx.h"
#include "renderer/shading/lobes/specular_albedo.h"

namespace emberline {

class AnisotropicGgx {
 public:
  AnisotropicGgx() = default;
  // Requires alphas in [kMirrorAlpha, 1] and a unit wo with wo.z > 0 (with another wo, the object
  // can be constructed but not used).
  AnisotropicGgx(float alpha_x, float alpha_y, const Vec3f& wo)
      : wo_(wo),
        alpha_x_(alpha_x),
        alpha_y_(alpha_y),
        inv_alpha_x_(1.0f / alpha_x),
        inv_alpha_y_(1.0f / alpha_y) {
    t_ = stretched_length(wo);
    const float s2 = square(1.0f + std::sqrt(fma(wo.x, wo.x, square(wo.y))));
    const float narrow2 = square(std::min(alpha_x, alpha_y));
    k_ = (1.0f - narrow2) * s2 / fma(narrow2, square(wo.z), s2);
  }

  // Maps u in [0, 1)^2 to a reflected direction. The caller must reject a result with z <= 0, which
  // carries no energy.
  Vec3f sample(const Vec2f& u) const {
    float sin_phi, cos_phi;
    sincos_turns(u.x, &sin_phi, &cos_phi);
    const Vec3f m = sample_cap(wo_, alpha_x_, alpha_y_, t_, k_, sin_phi, cos_phi, u.y);
    return fma(m, 2.0f * dot(wo_, m) / dot(m, m), -wo_);
  }

  using Value = GgxReflection::Value;
  // Requires wi.z > 0.
  [[gnu::always_inline]] Value evaluate(const Vec3f& wi) const {
    const Vec3f h = wo_ + wi;  // |h| = 2 cos_d for unit wo and wi
    const float length2 = fma(h.z, h.z, fma(h.x, h.x, square(h.y)));
    const float unstretched2 =
        fma(h.z, h.z, fma(square(h.x), square(inv_alpha_x_), square(h.y * inv_alpha_y_)));
    const float d = kInvPi * inv_alpha_x_ * inv_alpha_y_ * square(length2 / unstretched2);
    const float t_i = stretched_length(wi);
    return {0.5f * d * wi.z / fma(wi.z, t_, wo_.z * t_i), 0.5f * d / fma(k_, wo_.z, t_),
            std::min(1.0f, 0.5f * std::sqrt(length2))};
  }

 private:
  float stretched_length(const Vec3f& w) const {
    return std::sqrt(fma(w.z, w.z, fma(alpha_x_ * w.x, alpha_x_ * w.x, square(alpha_y_ * w.y))));
  }

  Vec3f wo_ = Vec3f(0.0f, 0.0f, 1.0f);
  float alpha_x_ = 1.0f, alpha_y_ = 1.0f, inv_alpha_x_ = 1.0f, inv_alpha_y_ = 1.0f;
  float t_ = 1.0f;  // length of (alpha_x wo.x, alpha_y wo.y, wo.z)
  float k_ = 0.0f;  // Eto & Tokuyoshi's bound on the cap
};

// The directional albedo of AnisotropicGgx, with the interface of SpecularAlbedo. It is the sum of
// two parts: the albedo of an isotropic lobe that has the alpha at the direction's azimuth, and a
// difference from a table over (cosine, azimuth, alpha_y, alpha_x). If alpha_x = alpha_y, the
// difference is 0. E and B are defined in specular_albedo.h. Errors were measured against
// quadrature at 20,000 points, including narrow lobes and grazing angles. The error in E is at most
// 1.5e-3, and below 9e-4 at 99 % of the points. The error in B is at most 1.7e-3, and below 6e-4 at
// 99 % of the points. The table (950 KiB) is built once, in 90 ms. The build is deterministic and
// thread-safe.
class AnisotropicAlbedo {
 public:
  // Requires alpha_x >= alpha_y (in glTF, x is the stretched direction), both in [kMirrorAlpha, 1].
  AnisotropicAlbedo(float alpha_x, float alpha_y);

  // Builds the table if it does not exist yet. Call this before rendering; otherwise, the first
  // sample waits for the build.
  static void prepare() { tables(); }

  SpecularAlbedo::Value at(const Vec3f& w) const;  // w unit, w.z in [0, 1]

  // Averages of at() over the hemisphere, weighted by the cosine.
  float average_loss() const { return average_loss_; }
  float average_schlick() const { return average_schlick_; }

 private:
  struct Node {
    float loss;  // difference in 1 - E
    float rest;  // difference in B - (1 - mu)^5 E
  };
  struct Tables;
  static const Tables& tables();
  AnisotropicAlbedo(float alpha_x, float alpha_y, const Tables& tables);

  float alpha_x2_, alpha_y2_;
  // roots_y_ holds alpha_y^p for p = 1, 1/2, 1/4, 1/8. sums_ is the product of (alpha_x^p +
  // alpha_y^p) over these p.
  float roots_y_[4], sums_;
  const Node* nodes_;    // values at the first of 2 x 2 neighbouring pairs of alphas
  float narrow_, wide_;  // position between the pairs
  float average_loss_, average_schlick_;
};

}  // namespace emberline
