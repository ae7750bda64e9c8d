// The list of lobes of a SurfaceBsdf, for materials that transmit or have layers.
//
// From top to bottom, the lobes are the clear coat and the sheen (the layers), and below them, side
// by side, the base, the clear transmission (TransmissionLobe) and the diffuse transmission. Along
// a direction, a layer transmits the fraction T, which is 1 minus the layer's albedo. The lobes
// below a layer are scaled by min(T(wo), T(wi)). This factor is reciprocal and never adds energy.
// Cosine lobes are scaled by T(wo) T(wi) / K instead, where K is the mean of T over the lobe. This
// factor is also reciprocal, and it loses no energy (it is the coupling of Ashikhmin & Shirley
// 2000, which the base itself uses as well).
#include <array>

#include "renderer/core/warps.h"
#include "renderer/shading/bsdf_base.h"
#include "renderer/shading/gauss_legendre.h"

namespace emberline {

namespace {

constexpr float kCoatF0 = 0.04f;  // index 1.5 (KHR_materials_clearcoat)
// Like kSpecularPickFloor in bsdf_base.h, but for every lobe of the list. We chose the value.
constexpr float kLobePickFloor = 0.1f;

// Returns w in a frame that is rotated about Z so that its x axis is the unit vector `axis`.
Vec3f rotate(const Vec3f& w, const Vec2f& axis) {
  return {fma(w.x, axis.x, w.y * axis.y), fma(w.y, axis.x, -w.x * axis.y), w.z};
}
Vec3f rotate_back(const Vec3f& w, const Vec2f& axis) { return rotate(w, Vec2f(axis.x, -axis.y)); }

// Approximates a film's reflectance by Schlick's formula with F90 = 1. With F0 = `f0`, the formula
// has the same hemispherical mean as the film. With F0 = `max_f0`, the formula is nowhere below the
// film's largest channel, so that the layer below the film never returns more light than it gets.
// `max_f0` is the smallest value with this property.
struct SchlickFit {
  Rgb f0;
  float max_f0;
};
SchlickFit fit_film(const ThinFilm& film, const Rgb& base_f0) {
  static const GaussLegendre<6> rule;
  SchlickFit fit{Rgb(0.0f), 0.0f};
  for (size_t i = 0; i < rule.x.size(); ++i) {
    const float mu = std::sqrt(float(rule.x[i]));  // cosine-weighted directions
    const Rgb f = film.reflectance(mu, base_f0);
    fit.f0 += f * float(rule.w[i]);
    const float grazing = pow5(1.0f - mu);
    fit.max_f0 = std::max(fit.max_f0, (max_component(f) - grazing) / (1.0f - grazing));
  }
  for (int c = 0; c < 3; ++c) fit.f0[c] = std::max(0.0f, (21.0f * fit.f0[c] - 1.0f) / 20.0f);
  return fit;
}

// The quadrature directions that attenuate_base() uses for every surface.
struct CoverRule {
  static constexpr size_t kNodes = 8;
  std::array<Vec3f, kNodes> direction;
  std::array<float, kNodes> weight;
  std::array<TablePosition, kNodes> column;  // in the sheen's table

  CoverRule() {
    static const GaussLegendre<kNodes> rule;
    for (size_t i = 0; i < kNodes; ++i) {
      // With mu = x^2, the nodes concentrate at grazing angles, where layers reflect most.
      const auto x = float(rule.x[i]);
      const float mu = square(x);
      const float across = safe_sqrt(0.5f * (1.0f - mu * mu));
      direction[i] = Vec3f(across, across, mu);
      weight[i] = float(rule.w[i]) * mu * x;
      column[i] = SheenLobe::column_of(mu);
    }
  }
};

Color4 mix(Color4 a, Color4 b, float t) { return a * (1.0f - t) + b * t; }

}  // namespace

const LayerParameters SurfaceBsdf::kNoLayers;

[[gnu::noinline]] SurfaceBsdf::SurfaceBsdf(const BsdfParameters& parameters,
                                           const LayerParameters& layers, const Vec3f& wo,
                                           const Vec3f& geometric_normal)
    : wo_(wo),
      ggx_(std::max(square(parameters.roughness), kMirrorAlpha), wo),
      table_(parameters.roughness) {
  if (!(wo.z > 0.0f)) return;
  make_list(parameters, layers);
  set_geometric_normal(geometric_normal);
}

[[gnu::noinline]] void SurfaceBsdf::make_list(const BsdfParameters& parameters,
                                              const LayerParameters& layers) {
  LobeList& list = list_.emplace();
  list.solid =
      !parameters.thin_walled && (parameters.transmission > 0 || layers.diffuse_transmission > 0);
  list.behind = list.solid && layers.behind;
  list.film = {layers.iridescence, layers.iridescence_ior, layers.iridescence_thickness};
  // With metalness m and transmission t, the material is a mix of metal (weight m), clear
  // dielectric (weight (1 - m) t) and diffuse dielectric (the rest). The base consists of the metal
  // and the diffuse dielectric. The base's metalness is the share of metal in the base.
  const float clear = parameters.transmission * (1.0f - parameters.metallic);
  list.clear_weight = clear;
  list.base_weight = 1.0f - clear;
  if (clear < 1.0f) {
    BsdfParameters base = parameters;
    base.metallic = std::min(1.0f, parameters.metallic / (1.0f - clear));
    make_layered_base(base, layers);
  }
  if (clear > 0.0f) {
    list.clear.emplace(TransmissionParameters{.tint = parameters.base_color,
                                              .roughness = parameters.roughness,
                                              .ior = parameters.ior,
                                              .specular = parameters.specular,
                                              .specular_color = parameters.specular_color,
                                              .film = list.film,
                                              .thin_walled = parameters.thin_walled,
                                              .inside = parameters.inside},
                       wo_);
  }
  if (layers.clearcoat > 0.0f || max_component(layers.sheen_color) > 0.0f) add_layers(layers);
  list.only_clear = clear == 1.0f && !list.layers;
  if (list.only_clear) {
    list.pick[kClear] = 1.0f;
    list.last = kClear;
    list.non_delta = list.transmits_non_delta = !list.clear->is_delta();
    albedo_ = color4(list.clear->albedo());
  } else {
    set_picks();
  }
}

void SurfaceBsdf::make_layered_base(const BsdfParameters& p, const LayerParameters& layers) {
  const ThinFilm& film = list_->film;
  SpecialBase& base = list_->base.emplace();
  Reflection r;
  const float alpha = std::max(square(p.roughness), kMirrorAlpha);
  const float alpha_x = std::min(1.0f, lerp(alpha, 1.0f, square(layers.anisotropy)));
  if (layers.anisotropy > 0.0f && alpha_x > kMirrorAlpha) {
    specular_ = SpecularKind::kAnisotropic;
    base.axis = layers.anisotropy_direction;
    base.anisotropic = AnisotropicGgx(alpha_x, alpha, rotate(wo_, base.axis));
    base.anisotropic_albedo.emplace(alpha_x, alpha);
    r.average_loss = base.anisotropic_albedo->average_loss();
    r.average_schlick = base.anisotropic_albedo->average_schlick();
  } else {
    specular_ = table_.is_mirror() ? SpecularKind::kMirror : SpecularKind::kGgx;
    r.average_loss = table_.average_loss();
    r.average_schlick = table_.average_schlick();
  }
  r.at_wo = reflection_albedo(wo_);

  r.dielectric = dielectric_f0(p);
  r.dielectric_f90 = p.specular;
  r.metal = color4(p.base_color, r.dielectric[3]);
  r.coloured = true;
  base.metallic = p.metallic;
  base.bare_f0 = fma(r.metal, p.metallic, r.dielectric * (1.0f - p.metallic));
  base.bare_f90 = lerp(p.specular, 1.0f, p.metallic);
  if (film.exists()) {
    base.metal_f0 = p.base_color;
    base.dielectric_f0 = to_rgb(r.dielectric);
    if (p.metallic < 1.0f) {
      const SchlickFit fit = fit_film(film, base.dielectric_f0);
      r.dielectric = mix(r.dielectric, color4(fit.f0, fit.max_f0), film.strength);
    }
    if (p.metallic > 0.0f) {
      r.metal = mix(r.metal, color4(fit_film(film, base.metal_f0).f0), film.strength);
    }
    r.metal[3] = r.dielectric[3];
    r.dielectric_f90 = lerp(r.dielectric_f90, 1.0f, film.strength);
  }
  const float specular = make_base(p, r);

  const float share = layers.diffuse_transmission;
  const float average = dielectric_reflectance(r.average_loss, r.average_schlick);
  if (!(share > 0.0f) || p.metallic == 1.0f || !(average < 1.0f - 1e-5f)) return;
  const float enters = (1.0f - p.metallic) *
                       std::max(0.0f, 1.0f - dielectric_reflectance(r.at_wo.loss, r.at_wo.schlick));
  const Color4 color = color4(layers.diffuse_transmission_color) * share;
  base.transmitted_diffuse_albedo = color * enters;
  base.transmitted_diffuse = color * (enters / (1.0f - average));
  diffuse_ *= 1.0f - share;
  albedo_ -= color4(p.base_color) * (share * enters);
  specular_pick_ = pick_probability(specular, sum(albedo_) - specular);
}

// Returns the directional albedo of the base's reflection lobe for F = 1.
SpecularAlbedo::Value SurfaceBsdf::reflection_albedo(const Vec3f& w) const {
  if (specular_ != SpecularKind::kAnisotropic) return table_.at(w.z);
  const SpecialBase& base = *list_->base;
  return base.anisotropic_albedo->at(rotate(w, base.axis));
}

void SurfaceBsdf::add_layers(const LayerParameters& parameters) {
  Layers& layers = list_->layers.emplace();
  layers.coat_weight = parameters.clearcoat;
  layers.sheen_color = parameters.sheen_color;
  layers.sheen_max = max_component(parameters.sheen_color);
  if (layers.coat_weight > 0.0f) {
    layers.coat_frame = ShadingFrame::from_normal(parameters.clearcoat_normal);
    Vec3f wo = layers.coat_frame.to_local(wo_);
    if (!(wo.z > 0.0f)) {
      layers.coat_frame = ShadingFrame::from_normal(Vec3f(0.0f, 0.0f, 1.0f));
      wo = layers.coat_frame.to_local(wo_);
    }
    layers.coat_albedo = SpecularAlbedo(parameters.clearcoat_roughness);
    const float alpha = std::max(square(parameters.clearcoat_roughness), kMirrorAlpha);
    layers.coat = GgxReflection(alpha, wo);
  }
  if (layers.sheen_max > 0.0f) layers.sheen = SheenLobe(parameters.sheen_roughness, wo_);
  if (list_->behind) return;
  layers.coat_transmittance_o = coat_transmittance(dot(wo_, layers.coat_frame.normal));
  layers.sheen_transmittance_o = sheen_transmittance(wo_.z);
  list_->transmittance_o = layers.coat_transmittance_o * layers.sheen_transmittance_o;
  if (list_->base) attenuate_base();
}

float SurfaceBsdf::coat_transmittance(float mu) const {
  const Layers& layers = *list_->layers;
  if (!(layers.coat_weight > 0.0f)) return 1.0f;
  const SpecularAlbedo::Value at = layers.coat_albedo.at(std::min(1.0f, std::abs(mu)));
  return 1.0f - layers.coat_weight * fma(1.0f - kCoatF0, at.schlick, kCoatF0 * (1.0f - at.loss));
}

float SurfaceBsdf::sheen_transmittance(const auto& at) const {
  const Layers& layers = *list_->layers;
  if (!(layers.sheen_max > 0.0f)) return 1.0f;
  return 1.0f - layers.sheen_max * layers.sheen.albedo(at);
}

// Returns the transmittance of the layers along w. It is 1 on the inner side of a solid, which has
// no layers.
float SurfaceBsdf::layer_transmittance(const Vec3f& w) const {
  const LobeList& list = *list_;
  if (!list.layers || (list.solid && list.behind == (w.z > 0.0f))) return 1.0f;
  return coat_transmittance(dot(w, list.layers->coat_frame.normal)) *
         sheen_transmittance(std::abs(w.z));
}

// Scales the cosine lobes by T(wo) / K (see the top of this file).
void SurfaceBsdf::attenuate_base() {
  static const CoverRule rule;
  LobeList& list = *list_;
  std::array<SpecularAlbedo::Value, CoverRule::kNodes> at;
  std::array<float, CoverRule::kNodes> transmittance;
  for (size_t i = 0; i < at.size(); ++i) at[i] = reflection_albedo(rule.direction[i]);
  for (size_t i = 0; i < at.size(); ++i) {
    transmittance[i] =
        coat_transmittance(rule.direction[i].z) * sheen_transmittance(rule.column[i]);
  }
  float diffuse = 0.0f, multiple = 0.0f, transmitted_diffuse_sum = 0.0f,
        transmitted_multiple_sum = 0.0f;
  for (size_t i = 0; i < at.size(); ++i) {
    const float enters =
        rule.weight[i] * std::max(0.0f, 1.0f - dielectric_reflectance(at[i].loss, at[i].schlick));
    const float scattered = rule.weight[i] * at[i].loss;
    diffuse += enters;
    transmitted_diffuse_sum += enters * transmittance[i];
    multiple += scattered;
    transmitted_multiple_sum += scattered * transmittance[i];
  }
  const auto covered = [&](float bare, float crossing) {
    return crossing > 0.0f ? list.transmittance_o * bare / crossing : 0.0f;
  };
  diffuse_ *= covered(diffuse, transmitted_diffuse_sum);
  multiple_ *= covered(multiple, transmitted_multiple_sum);
  list.base->transmitted_diffuse *=
      list.solid ? list.transmittance_o : covered(diffuse, transmitted_diffuse_sum);
}

// Sets the pick probability of each lobe in proportion to its albedo for white light, but raises
// the probability of weak lobes.
void SurfaceBsdf::set_picks() {
  LobeList& list = *list_;
  Color4 albedo[kLobes] = {};
  if (list.base) {
    albedo[kBase] = albedo_ * (list.base_weight * list.transmittance_o);
    albedo[kDiffuseTransmission] =
        list.base->transmitted_diffuse_albedo * (list.base_weight * list.transmittance_o);
  }
  if (list.clear_weight > 0.0f) {
    albedo[kClear] = color4(list.clear->albedo()) * (list.clear_weight * list.transmittance_o);
  }
  if (list.layers && !list.behind) {
    const Layers& layers = *list.layers;
    albedo[kCoat] = splat4(1.0f - layers.coat_transmittance_o);
    if (layers.sheen_max > 0.0f) {
      const float share = (1.0f - layers.sheen_transmittance_o) / layers.sheen_max;
      albedo[kSheen] = color4(layers.sheen_color) * (share * layers.coat_transmittance_o);
    }
  }
  albedo_ = splat4(0.0f);
  for (const Color4& a : albedo) albedo_ += a;
  const float total = sum(albedo_);
  if (!(total > 0.0f)) return;
  float boosted = 0.0f;
  for (int i = 0; i < kLobes; ++i) {
    const float share = sum(albedo[i]) / total;
    list.pick[i] = std::max(share, std::min(kPickBoost * share, kLobePickFloor));
    boosted += list.pick[i];
    if (list.pick[i] > 0.0f) list.last = i;
  }
  for (float& pick : list.pick) pick /= boosted;
  list.only_reflects = list.pick[kClear] == 0.0f && list.pick[kDiffuseTransmission] == 0.0f;
  const bool passes_clear = list.pick[kClear] > 0.0f && !list.clear->is_delta();
  list.transmits_non_delta = passes_clear || list.pick[kDiffuseTransmission] > 0.0f;
  list.non_delta = list.transmits_non_delta || list.pick[kSheen] > 0.0f ||
                   (list.pick[kCoat] > 0.0f && !list.layers->coat_albedo.is_mirror());
}

// Returns the Fresnel reflectance of a microfacet of the base. `cos_d` is the cosine of incidence.
Color4 SurfaceBsdf::base_fresnel(float cos_d) const {
  const SpecialBase& base = *list_->base;
  const ThinFilm& film = list_->film;
  const Color4 bare = schlick(base.bare_f0, base.bare_f90, cos_d);
  if (!film.exists()) return bare;
  Rgb covered(0.0f);
  if (base.metallic > 0.0f) covered += film.reflectance(cos_d, base.metal_f0) * base.metallic;
  if (base.metallic < 1.0f) {
    covered += film.reflectance(cos_d, base.dielectric_f0) * (1.0f - base.metallic);
  }
  return mix(bare, color4(covered), film.strength);
}

// `transmittance` is min(T(wo), T(wi)), `transmittance_i` is T(wi). wi must be above the surface.
Color4 SurfaceBsdf::eval_base(const Vec3f& wi, float transmittance, float transmittance_i,
                              float* pdf) const {
  Color4 value = splat4(0.0f);
  *pdf = 0.0f;
  const auto add_reflection = [&](const auto& lobe) {
    value = base_fresnel(lobe.cos_d) * (lobe.cosine_brdf * transmittance);
    *pdf = specular_pick_ * lobe.pdf;
  };
  if (specular_ == SpecularKind::kGgx) add_reflection(ggx_.evaluate(wi));
  if (specular_ == SpecularKind::kAnisotropic) {
    add_reflection(list_->base->anisotropic.evaluate(rotate(wi, list_->base->axis)));
  }
  if (has_cosine_) {
    value += eval_cosine(wi, reflection_albedo(wi)) * transmittance_i;
    *pdf = fma(1.0f - specular_pick_, cosine_pdf(wi), *pdf);
  }
  return value;
}

// Evaluates a white cosine lobe under the dielectric's interface. `above` is wi, mirrored to wo's
// side if needed. `cos_geometric` is the cosine between wi and the geometric normal on wi's side.
float SurfaceBsdf::interface_cosine(const Vec3f& above, float cos_geometric) const {
  const SpecularAlbedo::Value at = reflection_albedo(above);
  float scale = above.z * kInvPi;
  if (normals_differ_) scale *= terminator_factor(cos_geometric, terminator_alpha2_);
  return scale * std::max(0.0f, 1.0f - dielectric_reflectance(at.loss, at.schlick));
}

// Evaluates diffuse transmission; requires wi.z < 0.
Color4 SurfaceBsdf::eval_diffuse_transmission(const Vec3f& wi) const {
  const Vec3f above(wi.x, wi.y, -wi.z);
  return list_->base->transmitted_diffuse * interface_cosine(above, -dot(wi, geometric_normal_));
}

// Requires wi.z > 0.
Color4 SurfaceBsdf::eval_sheen(const Vec3f& wi) const {
  const Layers& layers = *list_->layers;
  const float under_coat =
      std::min(layers.coat_transmittance_o, coat_transmittance(dot(wi, layers.coat_frame.normal)));
  return color4(layers.sheen_color) * (layers.sheen.eval(wi) * under_coat);
}

Rgb SurfaceBsdf::eval_diffuse(const Vec3f& wi) const {
  if (below_surface(wi)) return Rgb(0.0f);
  Color4 value = splat4(0.0f);
  if (has_cosine_ && (!list_ || list_->base)) {
    value = diffuse_ * interface_cosine(wi, dot(wi, geometric_normal_));
    if (list_) value *= splat4(list_->base_weight * layer_transmittance(wi));
  }
  if (list_ && list_->pick[kSheen] > 0.0f) value += eval_sheen(wi);
  return to_rgb(value);
}

// Evaluates the coat's reflection; requires wi.z > 0.
float SurfaceBsdf::eval_coat(const Vec3f& wi, float* pdf) const {
  const Layers& layers = *list_->layers;
  *pdf = 0.0f;
  const Vec3f local = layers.coat_frame.to_local(wi);
  if (layers.coat_albedo.is_mirror() || !(local.z > 0.0f)) return 0.0f;
  const GgxReflection::Value lobe = layers.coat.evaluate(local);
  *pdf = lobe.pdf;
  return layers.coat_weight * lerp(kCoatF0, 1.0f, pow5(1.0f - lobe.cos_d)) * lobe.cosine_brdf;
}

[[gnu::noinline]] Rgb SurfaceBsdf::eval_list(const Vec3f& wi, float* pdf) const {
  const LobeList& list = *list_;
  *pdf = 0.0f;
  const bool transmitted = wi.z < 0.0f;
  if (wi.z == 0.0f || on_wrong_side(wi, transmitted)) return Rgb(0.0f);
  if (list.only_clear) return list.clear->eval_and_pdf(wi, pdf);
  const float transmittance_i = layer_transmittance(wi);
  const float transmittance = std::min(list.transmittance_o, transmittance_i);
  Color4 value = splat4(0.0f);
  float density = 0.0f;
  const auto add = [&](Lobe lobe, Color4 f) {
    value += f;
    *pdf = fma(density, list.pick[lobe], *pdf);
  };
  if (list.pick[kClear] > 0.0f) {
    const Color4 f = color4(list.clear->eval_and_pdf(wi, &density));
    add(kClear, f * (list.clear_weight * transmittance));
  }
  if (transmitted) {
    if (list.pick[kDiffuseTransmission] > 0.0f) {
      density = -wi.z * kInvPi;
      add(kDiffuseTransmission,
          eval_diffuse_transmission(wi) * (list.base_weight * transmittance_i));
    }
    return to_rgb(value);
  }
  if (list.pick[kBase] > 0.0f) {
    const Color4 f = eval_base(wi, transmittance, transmittance_i, &density);
    add(kBase, f * list.base_weight);
  }
  if (list.pick[kSheen] > 0.0f) {
    density = list.layers->sheen.pdf(wi);
    add(kSheen, eval_sheen(wi));
  }
  if (list.pick[kCoat] > 0.0f) add(kCoat, splat4(eval_coat(wi, &density)));
  return to_rgb(value);
}

// Samples the base: sets the direction and, for a mirror, also the weight.
BsdfSample SurfaceBsdf::sample_base(const Vec2f& u) const {
  BsdfSample result;
  result.valid = true;
  const bool specular = u.y < specular_pick_;
  const float share = specular ? specular_pick_ : 1.0f - specular_pick_;
  const Vec2f rest(u.x,
                   std::min((u.y - (specular ? 0.0f : specular_pick_)) / share, kOneMinusEpsilon));
  if (!specular) {
    result.wi = guide_ ? CosineGuide::direction_of(guide_->sample(rest))
                       : square_to_cosine_hemisphere(rest);
  } else if (specular_ == SpecularKind::kMirror) {
    result.wi = Vec3f(-wo_.x, -wo_.y, wo_.z);
    result.delta = true;
    result.weight = to_rgb(base_fresnel(wo_.z) * (list_->base_weight / specular_pick_));
  } else if (specular_ == SpecularKind::kGgx) {
    result.wi = ggx_.sample(rest);
  } else {
    result.wi = rotate_back(list_->base->anisotropic.sample(rest), list_->base->axis);
  }
  return result;
}

BsdfSample SurfaceBsdf::sample_coat(const Vec2f& u) const {
  const Layers& layers = *list_->layers;
  BsdfSample result;
  result.valid = true;
  const Vec3f wo = layers.coat_frame.to_local(wo_);
  if (layers.coat_albedo.is_mirror()) {
    result.wi = layers.coat_frame.to_world(Vec3f(-wo.x, -wo.y, wo.z));
    result.delta = true;
    result.weight =
        Rgb(layers.coat_weight * lerp(kCoatF0, 1.0f, pow5(1.0f - std::min(wo.z, 1.0f))));
  } else {
    result.wi = layers.coat_frame.to_world(layers.coat.sample(u));
  }
  return result;
}

[[gnu::noinline]] BsdfSample SurfaceBsdf::sample_list(float u_lobe, const Vec2f& u) const {
  const LobeList& list = *list_;
  if (list.only_clear) {
    const BsdfSample sample = list.clear->sample(u_lobe, u);
    return sample.valid && !on_wrong_side(sample.wi, sample.transmitted) ? sample : BsdfSample{};
  }
  int lobe = 0;
  while (lobe < list.last && !(u_lobe < list.pick[lobe])) u_lobe -= list.pick[lobe++];
  const float pick = list.pick[lobe];
  if (!(pick > 0.0f)) return BsdfSample{};
  BsdfSample result;
  result.valid = true;
  switch (lobe) {
    case kBase:
      result = sample_base(u);
      break;
    case kClear:
      result = list.clear->sample(std::min(u_lobe / pick, kOneMinusEpsilon), u);
      result.weight *= list.clear_weight;
      break;
    case kDiffuseTransmission:
      result.wi = square_to_cosine_hemisphere(u);
      result.wi.z = -result.wi.z;
      result.transmitted = true;
      break;
    case kSheen:
      result.wi = list.layers->sheen.sample(u);
      break;
    default:
      result = sample_coat(u);
  }
  if (!result.valid || result.transmitted != (result.wi.z < 0.0f) ||
      on_wrong_side(result.wi, result.transmitted)) {
    return BsdfSample{};
  }
  if (result.delta) {
    const float transmittance = std::min(list.transmittance_o, layer_transmittance(result.wi));
    result.weight *= (lobe == kCoat ? 1.0f : transmittance) / pick;
    return result;
  }
  const Rgb value = eval_list(result.wi, &result.pdf);
  if (!(result.pdf > 0.0f)) return BsdfSample{};
  result.weight = value / result.pdf;
  return result;
}

Rgb SurfaceBsdf::straight_transmittance() const {
  if (!list_ || !(list_->clear_weight > 0.0f) || on_wrong_side(-wo_, true)) return Rgb(0.0f);
  const float transmittance = std::min(list_->transmittance_o, layer_transmittance(-wo_));
  return list_->clear->straight_transmittance() * (list_->clear_weight * transmittance);
}

}  // namespace emberline
