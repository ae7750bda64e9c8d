#include "renderer/shading/bsdf.h"

#include "renderer/shading/bsdf_base.h"

namespace emberline {

// The members are constructed in place: copying fresh scalars would stall on store forwarding (15
// ns).
SurfaceBsdf::SurfaceBsdf(const BsdfParameters& parameters, const Vec3f& wo)
    : wo_(wo),
      ggx_(std::max(square(parameters.roughness), kMirrorAlpha), wo),
      table_(parameters.roughness) {
  if (!(wo.z > 0.0f)) return;
  if (parameters.transmission > 0.0f && parameters.metallic < 1.0f) {
    make_list(parameters, kNoLayers);
    return;
  }
  specular_ = table_.is_mirror() ? SpecularKind::kMirror : SpecularKind::kGgx;
  const Color4 dielectric = dielectric_f0(parameters);
  make_base(parameters, {.metal = color4(parameters.base_color, dielectric[3]),
                         .dielectric = dielectric,
                         .dielectric_f90 = parameters.specular,
                         .coloured = !is_grey(parameters.specular_color),
                         .at_wo = table_.at(wo.z),
                         .average_loss = table_.average_loss(),
                         .average_schlick = table_.average_schlick()});
}

SurfaceBsdf::SurfaceBsdf(const BsdfParameters& parameters, const Vec3f& wo,
                         const Vec3f& geometric_normal)
    : SurfaceBsdf(parameters, wo) {
  set_geometric_normal(geometric_normal);
}

void SurfaceBsdf::set_geometric_normal(const Vec3f& geometric_normal) {
  geometric_normal_ = geometric_normal;
  terminator_alpha2_ = terminator_alpha2(geometric_normal.z);
  normals_differ_ = geometric_normal.z < 1.0f;
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
      value += eval_cosine(wi, table_.at(wi.z));
      density = fma(1.0f - specular_pick_, cosine_pdf(wi), density);
    }
  }
  *pdf = density;
  return value;
}

Rgb SurfaceBsdf::eval_and_pdf(const Vec3f& wi, float* pdf) const {
  if (list_) return eval_list(wi, pdf);
  return to_rgb(eval_and_pdf4(wi, pdf));
}

Rgb SurfaceBsdf::eval(const Vec3f& wi) const {
  float unused;
  return eval_and_pdf(wi, &unused);
}

BsdfSample SurfaceBsdf::sample(float u_lobe, const Vec2f& u) const {
  return list_ ? sample_list(u_lobe, u) : sample_plain(u);
}

[[gnu::always_inline]] inline BsdfSample SurfaceBsdf::sample_plain(const Vec2f& u) const {
  BsdfSample result;
  // The lobes divide the unit square between them, so that stratified points stay stratified within
  // each lobe's part. A separate random choice would give each lobe a random subset.
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
  // Computes both lobes' directions and selects one. A branch would be mispredicted often, and a
  // misprediction costs more than the second direction.
  Vec2f point(u.x, v);
  if (guide_ && !specular) [[unlikely]]
    point = guide_->sample(point);
  float sine, cosine;
  sincos_turns(point.x, &sine, &cosine);
  const Vec3f a = ggx_.sample(sine, cosine, v);
  const float radius = std::sqrt(point.y);
  const Vec3f b(radius * cosine, radius * sine, std::sqrt(1.0f - point.y));
  result.wi =
      Vec3f(select(specular, a.x, b.x), select(specular, a.y, b.y), select(specular, a.z, b.z));
  const Color4 value = eval_and_pdf4(result.wi, &result.pdf);
  if (!(result.pdf > 0.0f)) return result;
  // Value and pdf contain the same D, so a narrow lobe's large numbers cancel in the ratio.
  result.weight = to_rgb(value / result.pdf);
  result.valid = true;
  return result;
}

}  // namespace emberline
