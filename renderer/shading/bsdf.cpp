#include "renderer/shading/bsdf.h"

#include <cassert>

#include "renderer/core/branch_free.h"
#include "renderer/core/constants.h"
#include "renderer/shading/shading_normal.h"

namespace emberline {

namespace {

float pow5(float x) { return square(square(x)) * x; }

// Schlick 1994, "An Inexpensive BRDF Model for Physically-based Rendering". f90 is 1 in plain glTF.
Color4 schlick(Color4 f0, float f90, float cos_d) { return fma(f90 - f0, pow5(1.0f - cos_d), f0); }

// Colour of the light that leaves after two or more bounces between microfacets: every bounce has
// the cosine-weighted mean Fresnel F, a share `loss` of it goes on to the next. Kulla & Conty 2017,
// "Revisiting Physically Based Shading at Imageworks", with F^2 for the two bounces at least (Hill
// 2018, "A Multi-Faceted Exploration, Part 3").
Color4 multiple_fresnel(Color4 f0, Color4 f90, float loss) {
  const Color4 f = fma(f90 - f0, 1.0f / 21.0f, f0);  // mean of Schlick: 2 int (1 - mu)^5 mu dmu
  return f * f * (1.0f - loss) / fma(-f, loss, splat4(1.0f));
}

// A lobe with a small share of the albedo is picked more often than that, up to these limits: the
// specular lobe because it sees the brightest things (highlights), the cosine lobe because its
// weight at grazing wi is many times its mean. Chosen by us.
constexpr float kPickBoost = 4.0f;
constexpr float kSpecularPickFloor = 0.1f;
constexpr float kCosinePickFloor = 0.02f;

float pick_probability(float specular, float cosine) {
  if (cosine <= 0.0f) return 1.0f;
  if (specular <= 0.0f) return 0.0f;
  const float share = specular / (specular + cosine);
  const float boosted = std::max(share, std::min(kPickBoost * share, kSpecularPickFloor));
  const float rest = 1.0f - share;
  return std::min(boosted, 1.0f - std::max(rest, std::min(kPickBoost * rest, kCosinePickFloor)));
}

float sum(Color4 c) { return c[0] + c[1] + c[2]; }

}  // namespace

// The parts are constructed in place: a copy of fresh scalars through wide registers would stall on
// store forwarding (measured: 15 ns).
SurfaceBsdf::SurfaceBsdf(const BsdfParameters& parameters, const Vec3f& wo)
    : wo_(wo),
      ggx_(std::max(square(parameters.roughness), kMirrorAlpha), wo),
      table_(parameters.roughness) {
  if (!(wo.z > 0.0f)) return;
  if (parameters.transmission > 0.0f && parameters.metallic < 1.0f) {
    add_clear_part(parameters);
    return;
  }
  const float metallic = parameters.metallic, through = 1.0f - metallic;
  const float ior = parameters.ior;
  assert(metallic >= 0 && metallic <= 1 && max_component(parameters.base_color) <= 1);

  // The dielectric rides along in the fourth lane: its F0, F90, Fms and albedo.
  dielectric_f90_ = parameters.specular;
  dielectric_f0_ = parameters.specular *
                   std::min(1.0f, parameters.specular_tint * square((ior - 1.0f) / (ior + 1.0f)));
  const Color4 pure = color4(parameters.base_color, dielectric_f0_);
  const Color4 pure90{1.0f, 1.0f, 1.0f, dielectric_f90_};
  f0_ = fma(pure, metallic, splat4(dielectric_f0_ * through));
  const Color4 f90 = fma(pure90, metallic, splat4(dielectric_f90_ * through));
  f90_ = f90[0];
  const SpecularAlbedo::Value at_wo = table_.at(wo.z);
  const Color4 single = fma(f90 - f0_, at_wo.schlick, f0_ * (1.0f - at_wo.loss));
  albedo_ = single;
  const float loss = table_.average_loss();
  if (f90_ == 0.0f) {  // no interface: a bare Lambertian base
  } else if (table_.is_mirror()) {
    specular_ = SpecularKind::kMirror;
  } else {
    specular_ = SpecularKind::kGgx;
    const Color4 fms = multiple_fresnel(pure, pure90, loss);
    dielectric_multiple_ = fms[3];
    const Color4 multiple = fma(fms, metallic, splat4(fms[3] * through));
    multiple_ = multiple * (at_wo.loss / loss);
    albedo_ = fma(multiple, at_wo.loss, albedo_);
    has_cosine_ = true;
  }
  if (through > 0.0f) {
    const float average = dielectric_reflectance(loss, table_.average_schlick());
    // Nothing gets through a dielectric that reflects everything.
    if (average < 1.0f - 1e-5f) {
      const float enters = through * std::max(0.0f, 1.0f - albedo_[3]);
      diffuse_ = pure * (enters / (1.0f - average));
      albedo_ = fma(pure, enters, albedo_);
      has_cosine_ = true;
    }
  }
  const float specular = sum(single);
  specular_pick_ = pick_probability(specular, sum(albedo_) - specular);
}

SurfaceBsdf::SurfaceBsdf(const BsdfParameters& parameters, const Vec3f& wo,
                         const Vec3f& geometric_normal)
    : SurfaceBsdf(parameters, wo) {
  geometric_normal_ = geometric_normal;
  terminator_alpha2_ = terminator_alpha2(geometric_normal.z);
  bent_ = geometric_normal.z < 1.0f;
}

[[gnu::always_inline]] inline Color4 SurfaceBsdf::eval_cosine(const Vec3f& wi) const {
  const SpecularAlbedo::Value at_wi = table_.at(wi.z);
  const float reflected = dielectric_reflectance(at_wi.loss, at_wi.schlick);
  float scale = wi.z * kInvPi;
  if (bent_) scale *= terminator_factor(dot(wi, geometric_normal_), terminator_alpha2_);
  return fma(diffuse_, std::max(0.0f, 1.0f - reflected), multiple_ * at_wi.loss) * scale;
}

[[gnu::always_inline]] inline Color4 SurfaceBsdf::eval_and_pdf4(const Vec3f& wi, float* pdf) const {
  Color4 value = splat4(0.0f);
  float density = 0.0f;
  if (!below_surface(wi)) {
    if (specular_ == SpecularKind::kGgx) {
      const GgxReflection::Value lobe = ggx_.evaluate(wi);
      value = schlick(f0_, f90_, lobe.cos_d) * lobe.cosine_brdf;
      density = specular_pick_ * lobe.pdf;
    }
    if (has_cosine_) {
      value += eval_cosine(wi);
      density = fma(1.0f - specular_pick_, wi.z * kInvPi, density);
    }
  }
  *pdf = density;
  return value;
}

Rgb SurfaceBsdf::eval_and_pdf(const Vec3f& wi, float* pdf) const {
  if (clear_) return eval_and_pdf_clear(wi, pdf);
  return to_rgb(eval_and_pdf4(wi, pdf));
}

Rgb SurfaceBsdf::eval(const Vec3f& wi) const {
  float unused;
  return eval_and_pdf(wi, &unused);
}

float SurfaceBsdf::pdf(const Vec3f& wi) const {
  if (clear_) {
    float density;
    eval_and_pdf_clear(wi, &density);
    return density;
  }
  if (below_surface(wi)) return 0.0f;
  float density = specular_ == SpecularKind::kGgx ? specular_pick_ * ggx_.evaluate(wi).pdf : 0.0f;
  if (has_cosine_) density = fma(1.0f - specular_pick_, wi.z * kInvPi, density);
  return density;
}

BsdfSample SurfaceBsdf::sample(float u_lobe, const Vec2f& u) const {
  return clear_ ? sample_clear(u_lobe, u) : sample_opaque(u);
}

[[gnu::always_inline]] inline BsdfSample SurfaceBsdf::sample_opaque(const Vec2f& u) const {
  BsdfSample result;
  // The lobes divide the unit square between them: points that are well spread over it stay so over
  // each part, where a coin apart would leave each lobe a random selection of them.
  const bool specular = u.y < specular_pick_;
  const float share = select(specular, specular_pick_, 1.0f - specular_pick_);
  const float v =
      std::min((u.y - select(specular, 0.0f, specular_pick_)) / share, kOneMinusEpsilon);
  if (specular && specular_ == SpecularKind::kMirror) {
    result.wi = Vec3f(-wo_.x, -wo_.y, wo_.z);
    result.weight = to_rgb(schlick(f0_, f90_, wo_.z) / specular_pick_);
    result.delta = true;
    result.valid = !below_surface(result.wi);
    return result;
  }
  // Both lobes' directions are made and one is taken: the coin cannot be predicted, and a wrong
  // guess would cost more (measured) than the few instructions of the other map.
  float sine, cosine;
  sincos_turns(u.x, &sine, &cosine);
  const Vec3f a = ggx_.sample(sine, cosine, v);
  const float radius = std::sqrt(v);
  const Vec3f b(radius * cosine, radius * sine, std::sqrt(1.0f - v));
  result.wi =
      Vec3f(select(specular, a.x, b.x), select(specular, a.y, b.y), select(specular, a.z, b.z));
  const Color4 value = eval_and_pdf4(result.wi, &result.pdf);
  if (!(result.pdf > 0.0f)) return result;
  // Both carry the same D, so a narrow lobe's large numbers cancel to rounding: the weight form.
  result.weight = to_rgb(value / result.pdf);
  result.valid = true;
  return result;
}

// ---- with a clear part
// -----------------------------------------------------------------------------

// A material of metal m, clear dielectric (1 - m) t and diffuse dielectric (1 - m)(1 - t): the
// opaque two are the model above with their metalness among themselves.
[[gnu::cold, gnu::noinline]] void SurfaceBsdf::add_clear_part(const BsdfParameters& parameters) {
  const float weight = parameters.transmission * (1.0f - parameters.metallic);
  Rgb opaque_albedo(0.0f);
  const Vec3f wo = wo_;
  if (weight < 1.0f) {
    BsdfParameters opaque = parameters;
    opaque.transmission = 0.0f;
    opaque.metallic = std::min(1.0f, parameters.metallic / (1.0f - weight));
    *this = SurfaceBsdf(opaque, wo);
    opaque_albedo = to_rgb(albedo_);
  }
  clear_.emplace(TransmissionParameters{.tint = parameters.base_color,
                                        .roughness = parameters.roughness,
                                        .ior = parameters.ior,
                                        .specular = parameters.specular,
                                        .thin_walled = parameters.thin_walled,
                                        .inside = parameters.inside},
                 wo);
  clear_weight_ = weight;
  const Color4 clear = color4(clear_->albedo()) * weight;
  const Color4 rest = color4(opaque_albedo) * (1.0f - weight);
  albedo_ = clear + rest;
  clear_pick_ = pick_probability(sum(clear), sum(rest));
}

[[gnu::cold, gnu::noinline]] Rgb SurfaceBsdf::eval_and_pdf_clear(const Vec3f& wi,
                                                                 float* pdf) const {
  Color4 value = splat4(0.0f);
  *pdf = 0.0f;
  if (clear_weight_ < 1.0f) {
    value = eval_and_pdf4(wi, pdf) * (1.0f - clear_weight_);
    *pdf *= 1.0f - clear_pick_;
  }
  if (!on_wrong_side(wi, wi.z < 0.0f)) {
    float density;
    value += color4(clear_->eval_and_pdf(wi, &density)) * clear_weight_;
    *pdf += density * clear_pick_;
  }
  return to_rgb(value);
}

[[gnu::cold, gnu::noinline]] BsdfSample SurfaceBsdf::sample_clear(float u_lobe,
                                                                  const Vec2f& u) const {
  const bool clear = u_lobe < clear_pick_;
  const float pick = clear ? clear_pick_ : 1.0f - clear_pick_;
  const float rest = std::min((clear ? u_lobe : u_lobe - clear_pick_) / pick, kOneMinusEpsilon);
  BsdfSample result = clear ? clear_->sample(rest, u) : sample_opaque(u);
  if (!result.valid) return result;
  if (on_wrong_side(result.wi, result.transmitted)) return BsdfSample{};
  if (result.delta) {
    result.weight *= (clear ? clear_weight_ : 1.0f - clear_weight_) / pick;
  } else {
    const Rgb value = eval_and_pdf_clear(result.wi, &result.pdf);
    if (!(result.pdf > 0.0f)) return BsdfSample{};
    result.weight = value / result.pdf;
  }
  return result;
}

Rgb SurfaceBsdf::straight_through() const {
  if (!clear_ || on_wrong_side(-wo_, true)) return Rgb(0.0f);
  return clear_->straight_through() * clear_weight_;
}

}  // namespace emberline
