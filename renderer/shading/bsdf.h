// The scattering function at one surface point, built from the material's values at that point.
//
// Local shading space: the shading normal is +Z; wo and wi are unit vectors that point away from
// the surface. eval() and BsdfSample::weight include the cosine |wi.z|. Densities are per solid
// angle. The class does not depend on samplers or the scene, and has no virtual calls.
//
// Model (glTF 2.0 appendix B, with energy compensation): one GGX reflection lobe lies over a
// Lambertian base. Metalness interpolates the lobe's F0 between that of the dielectric and the base
// colour. The lobe also returns the energy of multiple scattering (Kulla & Conty 2017). The base is
// weighted by the dielectric's transmittance. The model is reciprocal, and conserves energy in a
// white furnace at every metalness and roughness. README.md gives the formulas and their sources.
//
// A material that transmits light, or that has any of the LayerParameters, is represented by a list
// of lobes: the base, which is this model with an optional anisotropic reflection or thin film; a
// TransmissionLobe; diffuse transmission; sheen; and clear coat. Other materials have no list,
// which costs them only a branch that is not taken. If a lobe transmits light, wi may be below the
// surface.
//
// If the geometric normal differs from the shading normal, directions below the geometric surface
// contribute nothing, and the cosine lobe is softened towards the shadow terminator
// (shading_normal.h). eval and sample both do this, so that light sampling and BSDF sampling agree.
#pragma once

#include <cassert>
#include <optional>

#include "renderer/core/color4.h"
#include "renderer/core/frame.h"
#include "renderer/core/vector.h"
#include "renderer/shading/layers.h"
#include "renderer/shading/lobes/anisotropic_ggx.h"
#include "renderer/shading/lobes/bsdf_sample.h"
#include "renderer/shading/lobes/cosine_guide.h"
#include "renderer/shading/lobes/ggx.h"
#include "renderer/shading/lobes/sheen_lobe.h"
#include "renderer/shading/lobes/specular_albedo.h"
#include "renderer/shading/lobes/thin_film.h"
#include "renderer/shading/lobes/transmission_lobe.h"

namespace emberline {

// A material's values at a point. base_color, metallic and roughness are in [0, 1].
struct BsdfParameters {
  Rgb base_color = Rgb(0.5f);
  float metallic = 0.0f;
  float roughness = 1.0f;  // glTF's roughness; alpha = roughness^2
  // The index of refraction (KHR_materials_ior): at least 1, or 0 for a dielectric that reflects
  // everything (the extension's compatibility value). The default is that of glTF without the
  // extension.
  float ior = 1.5f;
  // Scales the dielectric's F0 and F90; 0 leaves a bare Lambertian base.
  float specular = 1.0f;
  // Scales the dielectric's F0 per channel, to at most 1 (KHR_materials_specular).
  Rgb specular_color = Rgb(1.0f);
  // Fraction of the dielectric that is clear instead of diffuse (KHR_materials_transmission). The
  // fields below matter only if this or LayerParameters::diffuse_transmission is above 0.
  float transmission = 0.0f;
  bool thin_walled = true;  // no refraction, no interior; false with KHR_materials_volume
  bool inside = false;      // wo is inside the solid; see also LayerParameters::behind
};

class SurfaceBsdf {
 public:
  SurfaceBsdf() = default;  // absorbs everything
  // Looks up the albedos at wo. The surface absorbs everything unless wo.z > 0.
  SurfaceBsdf(const BsdfParameters& parameters, const Vec3f& wo);
  // `geometric_normal` is a unit vector in local space, on wo's side (dot with wo >= 0).
  SurfaceBsdf(const BsdfParameters& parameters, const Vec3f& wo, const Vec3f& geometric_normal);
  SurfaceBsdf(const BsdfParameters& parameters, const LayerParameters& layers, const Vec3f& wo,
              const Vec3f& geometric_normal);

  // Returns f(wo, wi) |wi.z| without delta lobes. The result is 0 if wi is below the surface and no
  // lobe transmits.
  Rgb eval(const Vec3f& wi) const;
  // Returns eval() and stores in *pdf the density with which sample() returns wi (without delta
  // lobes). Costs little more than eval().
  Rgb eval_and_pdf(const Vec3f& wi, float* pdf) const;
  // `u_lobe` chooses a lobe from the list. The base divides `u` between its own two lobes.
  BsdfSample sample(float u_lobe, const Vec2f& u) const;
  // Returns the part of eval() that the Lambertian base and the sheen contribute; 0 below the
  // surface.
  Rgb eval_diffuse(const Vec3f& wi) const;

  // Samples the cosine lobe with this density from now on. `guide` must outlive the BSDF; null:
  // without a guide. Only allowed if can_be_guided().
  void set_guide(const CosineGuide* guide) {
    assert(can_be_guided());
    guide_ = guide;
  }
  // Whether there is a cosine lobe. False for surfaces that transmit light: what they scatter does
  // not come from one side alone.
  bool can_be_guided() const { return has_cosine_ && (!list_ || list_->only_reflects); }

  // Whether next-event estimation can contribute, because some lobe is not a delta.
  bool has_non_delta() const {
    return has_cosine_ || specular_ >= SpecularKind::kGgx || (list_ && list_->non_delta);
  }
  // Whether light samples from below the surface can contribute (LightQuery::both_sides).
  bool transmits_non_delta() const { return list_ && list_->transmits_non_delta; }
  // Returns the directional albedo at wo, including transmitted light, for the `albedo` AOV.
  Rgb albedo() const { return to_rgb(albedo_); }
  // Returns the transmittance along -wo, without refraction, if the surface is a smooth thin wall;
  // otherwise 0. The result is the expected weight of sample(), if only delta samples with
  // `transmitted` count.
  Rgb straight_transmittance() const;

 private:
  enum class SpecularKind : uint8_t { kNone, kMirror, kGgx, kAnisotropic };
  // The inputs of make_base(): F0 and F90 of the base's reflection, and the albedo of the
  // reflection lobe at wo.
  struct Reflection {
    Color4 metal;       // F0; fourth lane: largest channel of `dielectric`
    Color4 dielectric;  // F0; fourth lane: its largest channel
    float dielectric_f90;
    bool coloured;  // the dielectric's channels may be unequal
    SpecularAlbedo::Value at_wo;
    float average_loss, average_schlick;
  };

  // ---- the base
  // Returns the channel sum of the reflection's albedo without multiple scattering.
  float make_base(const BsdfParameters& parameters, const Reflection& reflection);
  // Returns f |wi.z| of the diffuse base and of multiple scattering, which share a cosine lobe.
  Color4 eval_cosine(const Vec3f& wi, const SpecularAlbedo::Value& at_wi) const;
  // Returns the albedo of the dielectric interface at one angle, given `loss` and `schlick` at that
  // angle.
  float dielectric_reflectance(float loss, float schlick) const {
    const float single =
        fma(dielectric_f90_ - dielectric_f0_, schlick, dielectric_f0_ * (1 - loss));
    return fma(dielectric_multiple_, loss, single);
  }
  Color4 eval_and_pdf4(const Vec3f& wi, float* pdf) const;
  // The density of the cosine lobe, with the guide.
  float cosine_pdf(const Vec3f& wi) const {
    const float pdf = wi.z * kInvPi;
    if (guide_) [[unlikely]]
      return pdf * guide_->density(wi);
    return pdf;
  }
  BsdfSample sample_plain(const Vec2f& u) const;
  void set_geometric_normal(const Vec3f& geometric_normal);
  [[gnu::always_inline]] bool below_surface(const Vec3f& wi) const {
    return !(wi.z > 0.0f) || (normals_differ_ && !(dot(wi, geometric_normal_) > 0.0f));
  }

  // ---- the list of lobes (bsdf_lobes.cpp); out of line, at no cost to plain materials
  enum Lobe : uint8_t { kBase, kClear, kDiffuseTransmission, kSheen, kCoat, kLobes };
  // Data that the base lobe needs only if the material has a list of lobes: thin film, anisotropy
  // and diffuse transmission.
  struct SpecialBase {
    Color4 bare_f0 = splat4(0.0f);  // without film
    float bare_f90 = 0.0f;
    float metallic = 0.0f;
    Rgb metal_f0, dielectric_f0;  // under the film
    Vec2f axis;                   // axis of the anisotropy
    AnisotropicGgx anisotropic;
    std::optional<AnisotropicAlbedo> anisotropic_albedo;
    // For diffuse transmission: the counterpart of diffuse_, and the albedo for white light.
    Color4 transmitted_diffuse = splat4(0.0f), transmitted_diffuse_albedo = splat4(0.0f);
  };
  // Coat and sheen. T is the transmittance along a direction.
  struct Layers {
    Rgb sheen_color;
    float sheen_max = 0.0f;  // largest of the colour's channels
    SheenLobe sheen;
    float coat_weight = 0.0f;
    GgxReflection coat;
    SpecularAlbedo coat_albedo;
    ShadingFrame coat_frame = ShadingFrame::from_normal(Vec3f(0.0f, 0.0f, 1.0f));
    float coat_transmittance_o = 1.0f, sheen_transmittance_o = 1.0f;  // T(wo) of each alone
  };
  struct LobeList {
    float pick[kLobes] = {};                        // sum to 1; 0 if a lobe is absent
    int last = 0;                                   // last lobe that is present
    float base_weight = 0.0f, clear_weight = 0.0f;  // fractions of the material
    bool solid = false, behind = false;             // solid: has an interior; behind: wo is in it
    bool only_clear = false;  // clear is the only lobe, with weight 1 and no layers
    bool only_reflects = false;
    bool non_delta = false, transmits_non_delta = false;
    float transmittance_o = 1.0f;  // T(wo)
    std::optional<TransmissionLobe> clear;
    ThinFilm film;
    std::optional<SpecialBase> base;  // present if base_weight is above 0
    std::optional<Layers> layers;
  };
  void make_list(const BsdfParameters& parameters, const LayerParameters& layers);
  static const LayerParameters kNoLayers;
  void make_layered_base(const BsdfParameters& parameters, const LayerParameters& layers);
  void add_layers(const LayerParameters& layers);
  void attenuate_base();
  void set_picks();
  float coat_transmittance(float mu) const;
  float sheen_transmittance(const auto& at) const;  // a cosine or a column of the sheen's table
  float layer_transmittance(const Vec3f& w) const;
  SpecularAlbedo::Value reflection_albedo(const Vec3f& w) const;
  Color4 base_fresnel(float cos_d) const;
  Color4 eval_base(const Vec3f& wi, float transmittance, float transmittance_i, float* pdf) const;
  float interface_cosine(const Vec3f& above, float cos_geometric) const;
  Color4 eval_diffuse_transmission(const Vec3f& wi) const;
  Color4 eval_sheen(const Vec3f& wi) const;
  float eval_coat(const Vec3f& wi, float* pdf) const;
  Rgb eval_list(const Vec3f& wi, float* pdf) const;  // everything except deltas
  BsdfSample sample_base(const Vec2f& u) const;
  BsdfSample sample_coat(const Vec2f& u) const;
  BsdfSample sample_list(float u_lobe, const Vec2f& u) const;
  [[gnu::always_inline]] bool on_wrong_side(const Vec3f& wi, bool transmitted) const {
    return normals_differ_ && !(dot(wi, geometric_normal_) * (transmitted ? -1.0f : 1.0f) > 0.0f);
  }

  // The fourth lane of colours is unused after construction.
  Color4 f0_ = splat4(0.0f);
  Color4 albedo_ = splat4(0.0f);
  // Cosine lobe: wi.z / pi * (multiple_ * (1 - E(wi)) + diffuse_ * (1 - Ed(wi))), where E is that
  // of SpecularAlbedo, and Ed is dielectric_reflectance().
  Color4 multiple_ = splat4(0.0f);
  Color4 diffuse_ = splat4(0.0f);
  float f90_ = 1.0f;
  float dielectric_f0_ = 0.0f, dielectric_f90_ = 1.0f;
  float dielectric_multiple_ = 0.0f;  // multiple_fresnel() of the dielectric
  float specular_pick_ = 0.0f;  // probability of the specular lobe rather than the cosine lobe
  SpecularKind specular_ = SpecularKind::kNone;
  const CosineGuide* guide_ = nullptr;
  bool has_cosine_ = false;
  bool normals_differ_ = false;
  Vec3f wo_ = Vec3f(0.0f, 0.0f, 1.0f);
  GgxReflection ggx_;
  SpecularAlbedo table_;
  Vec3f geometric_normal_ = Vec3f(0.0f, 0.0f, 1.0f);
  float terminator_alpha2_ = 0.0f;

  std::optional<LobeList> list_;  // if present, the members above belong to its base
};

}  // namespace emberline
