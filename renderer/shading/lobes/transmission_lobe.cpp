#include "renderer/shading/lobes/transmission_lobe.h"

#include <limits>

#include "renderer/core/branch_free.h"
#include "renderer/core/constants.h"
#include "renderer/shading/lobes/ggx.h"
#include "renderer/shading/lobes/specular_albedo.h"

namespace emberline {

namespace {

// An index that is closer to 1 than this does not refract, because the half vector would have no
// significant digits.
constexpr float kIndexMatchTolerance = 1e-3f;
// If reflection and transmission can both contribute, each has at least this pick probability. We
// chose the value.
constexpr float kPickFloor = 0.02f;

float mean(const Rgb& c) { return (c.x + c.y + c.z) * (1.0f / 3.0f); }

}  // namespace

float fresnel_dielectric(float cos_i, float eta) {
  const float sin2_t = fma(-cos_i, cos_i, 1.0f) / square(eta);
  if (sin2_t >= 1.0f) return 1.0f;
  const float cos_t = safe_sqrt(1.0f - sin2_t);
  const float parallel = fma(eta, cos_i, -cos_t) / fma(eta, cos_i, cos_t);
  const float perpendicular = fma(-eta, cos_t, cos_i) / fma(eta, cos_t, cos_i);
  return 0.5f * fma(parallel, parallel, square(perpendicular));
}

Rgb attenuation_coefficient(const Rgb& color, float distance) {
  if (!(distance > 0.0f) || !std::isfinite(distance)) return Rgb(0.0f);
  const auto channel = [distance](float c) {
    const float coefficient =
        -std::log(c > 1e-6f ? std::min(c, 1.0f) : 1e-6f) / distance;  // also for NaN
    return std::min(coefficient,
                    std::numeric_limits<float>::max());  // infinity x distance 0 is NaN
  };
  return {channel(color.x), channel(color.y), channel(color.z)};
}

Rgb beer_transmittance(const Rgb& coefficient, float distance) {
  return {std::exp(-coefficient.x * distance), std::exp(-coefficient.y * distance),
          std::exp(-coefficient.z * distance)};
}

TransmissionLobe::TransmissionLobe(const TransmissionParameters& p, const Vec3f& wo)
    : wo_(wo), tint_(p.tint), mean_tint_(mean(p.tint)), specular_(p.specular) {
  if (!(wo.z > 0.0f)) {  // absorbs everything
    wo_ = Vec3f(0.0f);
    return;
  }
  thin_ = p.thin_walled;
  mirror_only_ = p.ior == 0.0f;
  inside_ = p.inside && !thin_;
  if (!mirror_only_) eta_ = inside_ ? 1.0f / p.ior : p.ior;
  alpha_ = square(p.roughness);
  alpha2_ = square(alpha_);
  const bool straight = !thin_ && !mirror_only_ && std::abs(eta_ - 1.0f) < kIndexMatchTolerance;
  if (straight) {
    specular_ = 0.0f;
    eta_ = 1.0f;
  }
  film_ = p.film;
  coloured_ = film_.exists() || !(p.specular_color == Rgb(1.0f));
  if (coloured_) {
    plain_f0_ = mirror_only_ ? 1.0f : square((eta_ - 1.0f) / (eta_ + 1.0f));
    for (int c = 0; c < 3; ++c) base_f0_[c] = std::min(1.0f, plain_f0_ * p.specular_color[c]);
  }
  delta_ = alpha_ < kMirrorAlpha || straight;
  if (delta_) return;
  t_ = std::sqrt(fma(alpha2_, fma(wo.x, wo.x, square(wo.y)), square(wo.z)));
  const float albedo = thin_ || mirror_only_ ? 1.0f - SpecularAlbedo(p.roughness).at(wo.z).loss
                                             : refraction_albedo(wo.z, p.roughness, eta_);
  compensation_ = 1.0f / albedo;
}

Rgb TransmissionLobe::reflectance(float cos_d) const {
  const float f = mirror_only_ ? 1.0f : fresnel_dielectric(cos_d, eta_);
  // Total reflection returns all light, whatever specular_ and the colour are.
  if (f >= 1.0f && (!mirror_only_ || !coloured_)) return Rgb(1.0f);
  if (!coloured_) return Rgb(specular_ * f);
  // A coloured F0 becomes white as Fresnel's reflectance goes from F0 to 1.
  const float to_grazing =
      mirror_only_ ? square(square(1.0f - cos_d)) * (1.0f - cos_d)
                   : std::max(0.0f, (f - plain_f0_) / std::max(1.0f - plain_f0_, 1e-6f));
  const Rgb bare = fma(Rgb(1.0f) - base_f0_, to_grazing, base_f0_) * specular_;
  if (!film_.exists()) return bare;
  float cos_outside = cos_d;
  if (inside_) cos_outside = safe_sqrt(1.0f - fma(-cos_d, cos_d, 1.0f) / square(eta_));
  return bare * (1.0f - film_.strength) +
         film_.reflectance(cos_outside, base_f0_ * specular_) * film_.strength;
}

float TransmissionLobe::reflect_pick(const Rgb& reflectance) const {
  const float reflect = mean(reflectance);
  const float transmit = (1.0f - max_component(reflectance)) * mean_tint_;
  if (!(transmit > 0.0f)) return 1.0f;
  if (!(reflect > 0.0f)) return 0.0f;
  return std::clamp(reflect / (reflect + transmit), kPickFloor, 1.0f - kPickFloor);
}

bool TransmissionLobe::refract(const Vec3f& m, float cos_d, Vec3f* wi) const {
  const float inverse = 1.0f / eta_;
  const float sin2_t = fma(-cos_d, cos_d, 1.0f) * square(inverse);
  if (sin2_t >= 1.0f) return false;
  // When light leaves a dense medium, the terms are large and cancel, so the result must be
  // normalised.
  const float along_m = fma(cos_d, inverse, -safe_sqrt(1.0f - sin2_t));
  *wi = normalize(fma(m, along_m, wo_ * -inverse));
  return true;
}

Rgb TransmissionLobe::albedo() const {
  const Rgb f = reflectance(wo_.z);
  return fma(tint_, 1.0f - max_component(f), f);
}

Rgb TransmissionLobe::straight_transmittance() const {
  return thin_ && delta_ ? tint_ * (1.0f - max_component(reflectance(wo_.z))) : Rgb(0.0f);
}

Rgb TransmissionLobe::eval_and_pdf(const Vec3f& wi, float* pdf) const {
  *pdf = 0.0f;
  const float mu_i = std::abs(wi.z);
  if (delta_ || !(mu_i > 0.0f)) return Rgb(0.0f);
  const bool transmitted = wi.z < 0.0f;
  const bool refracts = transmitted && !thin_;
  // The unnormalised microfacet normal on wo's side (see ggx.h for the numerics).
  Vec3f h = refracts ? -fma(wi, eta_, wo_) : wo_ + Vec3f(wi.x, wi.y, mu_i);
  if (h.z < 0.0f) h = -h;
  const float xy2 = fma(h.x, h.x, square(h.y)), z2 = square(h.z), length2 = xy2 + z2;
  if (!(length2 > 0.0f) || !(z2 > 0.0f)) return Rgb(0.0f);
  const float inverse_length = 1.0f / std::sqrt(length2);
  const float cos_d = std::min(1.0f, dot(wo_, h) * inverse_length);
  if (!(cos_d > 0.0f)) return Rgb(0.0f);
  const float d = kInvPi / alpha2_ * square(length2 / (xy2 / alpha2_ + z2));
  const float t_i = std::sqrt(fma(1.0f - alpha2_, square(mu_i), alpha2_));
  const float smith = mu_i / fma(mu_i, t_, wo_.z * t_i);  // G2 / (2 |wo.z|)
  const Rgb reflected = reflectance(cos_d);
  const float transmittance = 1.0f - max_component(reflected);
  const float pick = reflect_pick(reflected);
  if (!refracts) {
    const float lobe = 0.5f * d * smith * compensation_;
    const float density = 0.5f * d / (t_ + wo_.z);
    *pdf = density * (transmitted ? 1.0f - pick : pick);
    return transmitted ? tint_ * (lobe * transmittance) : reflected * lobe;
  }
  const float cos_i = -dot(wi, h) * inverse_length;
  if (!(cos_i > 0.0f)) return Rgb(0.0f);
  // Walter et al. 2007, eq. 17 and 21; (eta wi.m + wo.m)^2 is the squared length of h.
  const float jacobian = cos_i / length2;
  *pdf = (1.0f - pick) * d * cos_d * 2.0f / (t_ + wo_.z) * jacobian * square(eta_);
  return tint_ * (transmittance * d * cos_d * 2.0f * smith * jacobian * compensation_);
}

BsdfSample TransmissionLobe::sample(float u_lobe, const Vec2f& u) const {
  BsdfSample result;
  Vec3f m(0.0f, 0.0f, 1.0f);
  if (!delta_) {
    float sine, cosine;
    sincos_turns(u.x, &sine, &cosine);
    m = normalize_or(sample_cap(wo_, alpha_, alpha_, t_, 1.0f, sine, cosine, u.y), m);
  }
  const float cos_d = std::min(1.0f, dot(wo_, m));
  if (!(cos_d > 0.0f)) return result;
  const Rgb reflected = reflectance(cos_d);
  const float transmittance = 1.0f - max_component(reflected);
  const float pick = reflect_pick(reflected);
  const bool transmits = !(u_lobe < pick);
  if (!transmits || thin_) {
    result.wi = fma(m, 2.0f * cos_d, -wo_);
    if (!(result.wi.z > 0.0f)) return result;
    if (transmits) result.wi.z = -result.wi.z;
  } else if (!refract(m, cos_d, &result.wi) || !(result.wi.z < 0.0f)) {
    return result;
  }
  result.transmitted = transmits;
  if (transmits && !thin_) result.eta_scale = square(eta_);
  if (delta_) {
    result.delta = true;
    result.weight =
        transmits ? tint_ * (transmittance / ((1.0f - pick) * result.eta_scale)) : reflected / pick;
  } else {
    const Rgb value = eval_and_pdf(result.wi, &result.pdf);
    if (!(result.pdf > 0.0f)) return result;
    result.weight = value / result.pdf;
  }
  result.valid = true;
  return result;
}

}  // namespace emberline
