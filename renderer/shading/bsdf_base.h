// Internals of SurfaceBsdf that bsdf.cpp and bsdf_lobes.cpp both inline.
#pragma once

#include <cassert>

#include "renderer/core/branch_free.h"
#include "renderer/core/constants.h"
#include "renderer/shading/bsdf.h"
#include "renderer/shading/shading_normal.h"

namespace emberline {

inline float sum(Color4 c) { return c[0] + c[1] + c[2]; }

// Evaluates the approximation of Schlick 1994, "An Inexpensive BRDF Model for Physically-based
// Rendering". In plain glTF, f90 is 1.
inline Color4 schlick(Color4 f0, float f90, float cos_d) {
  return fma(f90 - f0, pow5(1.0f - cos_d), f0);
}

// Returns the colour of the light that leaves after two or more bounces between microfacets. Every
// bounce multiplies the light by F, the cosine-weighted mean of the Fresnel reflectance, and a
// fraction `loss` of the light goes on to another bounce. Follows Kulla & Conty 2017, "Revisiting
// Physically Based Shading at Imageworks", but uses F^2 for the first two bounces (Hill 2018, "A
// Multi-Faceted Exploration, Part 3").
inline Color4 multiple_fresnel(Color4 f0, Color4 f90, float loss) {
  const Color4 f = fma(f90 - f0, 1.0f / 21.0f, f0);  // mean of Schlick: 2 int (1 - mu)^5 mu dmu
  return f * f * (1.0f - loss) / fma(-f, loss, splat4(1.0f));
}

// A lobe that contributes only a small fraction of the albedo is picked with a higher probability
// than this fraction: kPickBoost times the fraction, up to the lobe's floor. The specular lobe
// needs this because it shows the brightest features (highlights). The cosine lobe needs this
// because its weight at grazing wi is many times its mean. We chose all three values.
inline constexpr float kPickBoost = 4.0f;
inline constexpr float kSpecularPickFloor = 0.1f;
inline constexpr float kCosinePickFloor = 0.02f;

inline float pick_probability(float specular, float cosine) {
  if (cosine <= 0.0f) return 1.0f;
  if (specular <= 0.0f) return 0.0f;
  const float share = specular / (specular + cosine);
  const float boosted = std::max(share, std::min(kPickBoost * share, kSpecularPickFloor));
  const float rest = 1.0f - share;
  return std::min(boosted, 1.0f - std::max(rest, std::min(kPickBoost * rest, kCosinePickFloor)));
}

inline bool is_grey(const Rgb& c) { return c.x == c.y && c.y == c.z; }

// Returns F0 of the dielectric. The fourth lane is the largest of the three channels.
[[gnu::always_inline]] inline Color4 dielectric_f0(const BsdfParameters& p) {
  const float bare = square((p.ior - 1.0f) / (p.ior + 1.0f));
  const auto channel = [&](float color) { return p.specular * std::min(1.0f, color * bare); };
  const Rgb& color = p.specular_color;
  return Color4{channel(color.x), channel(color.y), channel(color.z),
                channel(max_component(color))};
}

[[gnu::always_inline]] inline float SurfaceBsdf::make_base(const BsdfParameters& parameters,
                                                           const Reflection& r) {
  const float metallic = parameters.metallic, dielectric_weight = 1.0f - metallic;
  assert(metallic >= 0 && metallic <= 1 && max_component(parameters.base_color) <= 1);

  // The fourth lane of each colour below holds the dielectric's value (F0, F90, albedo, or Fms, the
  // result of multiple_fresnel()).
  dielectric_f90_ = r.dielectric_f90;
  dielectric_f0_ = r.dielectric[3];
  const Color4 pure90{1.0f, 1.0f, 1.0f, dielectric_f90_};
  f0_ = fma(r.metal, metallic, r.dielectric * dielectric_weight);
  const Color4 f90 = fma(pure90, metallic, splat4(dielectric_f90_ * dielectric_weight));
  f90_ = f90[0];
  const SpecularAlbedo::Value at_wo = r.at_wo;
  const Color4 single = fma(f90 - f0_, at_wo.schlick, f0_ * (1.0f - at_wo.loss));
  albedo_ = single;
  const float loss = r.average_loss;
  if (f90_ == 0.0f) {  // no interface: a bare Lambertian base
    specular_ = SpecularKind::kNone;
  } else if (specular_ != SpecularKind::kMirror) {
    const Color4 fms = multiple_fresnel(r.metal, pure90, loss);
    dielectric_multiple_ = fms[3];
    Color4 dielectric_fms = splat4(fms[3]);
    if (r.coloured) {
      dielectric_fms = multiple_fresnel(r.dielectric, splat4(dielectric_f90_), loss);
    }
    const Color4 multiple = fma(fms, metallic, dielectric_fms * dielectric_weight);
    multiple_ = multiple * (at_wo.loss / loss);
    albedo_ = fma(multiple, at_wo.loss, albedo_);
    has_cosine_ = true;
  }
  if (dielectric_weight > 0.0f) {
    const float average = dielectric_reflectance(loss, r.average_schlick);
    // A dielectric that reflects everything transmits nothing.
    if (average < 1.0f - 1e-5f) {
      const Color4 base = color4(parameters.base_color);
      const float enters = dielectric_weight * std::max(0.0f, 1.0f - albedo_[3]);
      diffuse_ = base * (enters / (1.0f - average));
      albedo_ = fma(base, enters, albedo_);
      has_cosine_ = true;
    }
  }
  const float specular = sum(single);
  specular_pick_ = pick_probability(specular, sum(albedo_) - specular);
  return specular;
}

// `at_wi` is the albedo of the reflection lobe at wi.
[[gnu::always_inline]] inline Color4 SurfaceBsdf::eval_cosine(
    const Vec3f& wi, const SpecularAlbedo::Value& at_wi) const {
  const float reflected = dielectric_reflectance(at_wi.loss, at_wi.schlick);
  float scale = wi.z * kInvPi;
  if (normals_differ_) scale *= terminator_factor(dot(wi, geometric_normal_), terminator_alpha2_);
  return fma(diffuse_, std::max(0.0f, 1.0f - reflected), multiple_ * at_wi.loss) * scale;
}

}  // namespace emberline
