// The isotropic GGX (Trowbridge-Reitz) reflection lobe with height-correlated Smith masking, for
// one wo: sampling map, density, and value without Fresnel.
//
// Sampling: visible normals are sampled as spherical caps (Dupuy & Benyoub 2023, "Sampling Visible
// GGX Normals with Spherical Caps", HPG). The caps are bounded so that few reflections are below
// the horizon (Eto & Tokuyoshi 2023, "Bounded VNDF Sampling for the Smith-GGX BRDF", SIGGRAPH
// Asia). The ratio value / pdf is at most 1.
//
// Numerics: no expression here cancels, overflows or underflows if alpha >= kMirrorAlpha and wo.z >
// 0. sin^2 of the microfacet normal is computed from its x and y, since 1 - z^2 has no significant
// digits in float at alpha = 1e-3. The normal is never normalised; only its squared length is used.
#pragma once

#include <cmath>

#include "renderer/core/branch_free.h"
#include "renderer/core/constants.h"
#include "renderer/core/vector.h"

namespace emberline {

// Samples an unnormalised visible microfacet normal of a surface with two alphas. `t` is the length
// of (alpha_x wo.x, alpha_y wo.y, wo.z), and `k` is the bound on the cap. The result has z >= 0,
// since k <= 1.
[[gnu::always_inline]] inline Vec3f sample_cap(const Vec3f& wo, float alpha_x, float alpha_y,
                                               float t, float k, float sin_phi, float cos_phi,
                                               float u) {
  const float scale = 1.0f / t;
  const Vec3f o(alpha_x * wo.x * scale, alpha_y * wo.y * scale, wo.z * scale);
  const float one_minus_z = u * fma(k, o.z, 1.0f);
  const float r = safe_sqrt(one_minus_z * (2.0f - one_minus_z));
  return {alpha_x * fma(r, cos_phi, o.x), alpha_y * fma(r, sin_phi, o.y),
          std::max(0.0f, 1.0f - one_minus_z + o.z)};
}

class GgxReflection {
 public:
  GgxReflection() = default;
  // Requires alpha in [kMirrorAlpha, 1] and a unit wo with wo.z > 0 (with another wo, the object
  // can be constructed but not used).
  GgxReflection(float alpha, const Vec3f& wo) : wo_(wo), alpha_(alpha) {
    alpha2_ = square(alpha);
    inv_alpha2_ = 1.0f / alpha2_;
    const float sin2 = fma(wo.x, wo.x, square(wo.y));
    t_ = std::sqrt(fma(alpha2_, sin2, square(wo.z)));
    const float s2 = square(1.0f + std::sqrt(sin2));
    k_ = (1.0f - alpha2_) * s2 / fma(alpha2_, square(wo.z), s2);
  }

  // Maps u in [0, 1)^2 to a reflected direction. The caller must reject a result with z <= 0, which
  // carries no energy.
  Vec3f sample(const Vec2f& u) const {
    float sin_phi, cos_phi;
    sincos_turns(u.x, &sin_phi, &cos_phi);
    return sample(sin_phi, cos_phi, u.y);
  }
  // Like sample() above, for an azimuth whose sine and cosine are known.
  Vec3f sample(float sin_phi, float cos_phi, float u) const {
    const Vec3f m = sample_cap(wo_, alpha_, alpha_, t_, k_, sin_phi, cos_phi, u);
    return fma(m, 2.0f * dot(wo_, m) / dot(m, m), -wo_);
  }

  struct Value {
    float cosine_brdf;  // D G2 / (4 |wo.z| |wi.z|) * wi.z: the lobe for F = 1
    float pdf;          // density of sample() per solid angle
    float cos_d;        // cosine between wo and the half vector
  };
  // Requires wi.z > 0.
  [[gnu::always_inline]] Value evaluate(const Vec3f& wi) const {
    const Vec3f h = wo_ + wi;  // |h| = 2 cos_d for unit wo and wi
    const float xy2 = fma(h.x, h.x, square(h.y));
    const float length2 = fma(h.z, h.z, xy2);
    const float ratio = length2 / fma(xy2, inv_alpha2_, square(h.z));
    const float d = kInvPi * inv_alpha2_ * square(ratio);
    const float t_i = std::sqrt(fma(1.0f - alpha2_, square(wi.z), alpha2_));
    return {0.5f * d * wi.z / fma(wi.z, t_, wo_.z * t_i), 0.5f * d / fma(k_, wo_.z, t_),
            std::min(1.0f, 0.5f * std::sqrt(length2))};
  }

 private:
  Vec3f wo_;
  float alpha_ = 1.0f, alpha2_ = 1.0f, inv_alpha2_ = 1.0f;
  float t_ = 1.0f;  // sqrt(alpha^2 sin^2 + cos^2) of wo
  float k_ = 0.0f;  // Eto & Tokuyoshi's bound on the cap
};

}  // namespace emberline
