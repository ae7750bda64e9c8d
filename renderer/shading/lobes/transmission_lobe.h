// A dielectric interface that reflects and transmits light (KHR_materials_transmission, _ior,
// _volume). It is smooth or rough, and it is a thin wall or the boundary of a solid.
//
// Local space is as in bsdf.h, with normal +Z on wo's side. Solids follow Walter et al. 2007,
// "Microfacet Models for Refraction through Rough Surfaces", with height-correlated Smith GGX,
// exact Fresnel, and visible normals sampled as spherical caps (Dupuy & Benyoub 2023). A thin wall
// does not refract: its transmission has the distribution of the reflection, mirrored to the other
// side, as glTF defines it.
//
// Reflection and transmission are divided by the sum of their directional albedos at wo, to
// compensate for multiple scattering (Turquin 2019, "Practical Multiple Scattering Compensation for
// Microfacet Models"). So a white interface conserves energy, but it is not reciprocal.
//
// Where a path from the camera enters a denser medium, radiance is scaled by 1 / eta^2. Where the
// path leaves the medium again, the inverse scale cancels this. If alpha is below kMirrorAlpha,
// reflection and transmission are both deltas. An index within 1e-3 of 1 does not refract: light
// goes straight through.
#pragma once

#include "renderer/core/vector.h"
#include "renderer/shading/lobes/bsdf_sample.h"
#include "renderer/shading/lobes/thin_film.h"

namespace emberline {

struct TransmissionParameters {
  Rgb tint = Rgb(1.0f);    // of transmitted light, per crossing; [0, 1]
  float roughness = 0.0f;  // glTF's roughness; alpha = roughness^2
  float ior = 1.5f;        // of the solid relative to the outside; >= 1, or 0 to reflect everything
  float specular = 1.0f;   // weight of the reflection, [0, 1]
  Rgb specular_color = Rgb(1.0f);  // of the reflection at normal incidence
  ThinFilm film = {};              // on the outside
  bool thin_walled = true;
  bool inside = false;  // wo is inside the solid (the back face was hit); ignored if thin-walled
};

class TransmissionLobe {
 public:
  TransmissionLobe() = default;
  // The lobe absorbs everything unless wo.z > 0.
  TransmissionLobe(const TransmissionParameters& parameters, const Vec3f& wo);

  // Returns f |wi.z| and stores the density of sample() in *pdf. wi may be on either side. Both
  // values are 0 if is_delta().
  Rgb eval_and_pdf(const Vec3f& wi, float* pdf) const;
  BsdfSample sample(float u_lobe, const Vec2f& u) const;
  bool is_delta() const { return delta_; }
  // Returns the sum of reflectance and transmittance at wo, estimated as if the interface were
  // smooth.
  Rgb albedo() const;
  // Returns the transmittance of a smooth thin wall along -wo; 0 for any other lobe.
  Rgb straight_transmittance() const;

 private:
  // Returns the reflectance of a microfacet at the cosine of incidence cos_d. Every channel
  // transmits 1 minus the largest channel of the reflectance, so that the transmitted light does
  // not get the complementary colour of the reflection.
  Rgb reflectance(float cos_d) const;
  float reflect_pick(const Rgb& reflectance) const;
  bool refract(const Vec3f& m, float cos_d, Vec3f* wi) const;

  Vec3f wo_ = Vec3f(0.0f, 0.0f, 1.0f);
  Rgb tint_ = Rgb(0.0f);
  float mean_tint_ = 0.0f;
  float eta_ = 1.0f;  // index on the far side over index on wo's side
  float specular_ = 0.0f;
  bool coloured_ = false;  // whether the reflection is coloured; otherwise base_f0_ is unused
  Rgb base_f0_;            // F0 without specular_
  float plain_f0_ = 0.0f;  // F0 without specular_ and specular_color
  ThinFilm film_;
  float alpha_ = 0.0f, alpha2_ = 0.0f;
  float t_ = 1.0f;  // sqrt(alpha^2 sin^2 + cos^2) of wo
  float compensation_ = 1.0f;
  bool thin_ = true;
  bool delta_ = true;
  bool inside_ = false;       // wo is inside a solid
  bool mirror_only_ = false;  // ior = 0
};

// Returns the Fresnel reflectance of an interface between dielectrics; 1 for total internal
// reflection. `eta` is the index of the far side over that of the near side; `cos_i` is in [0, 1].
float fresnel_dielectric(float cos_i, float eta);

// Return the coefficients and the transmittance of Beer's law in a solid (KHR_materials_volume):
// white light becomes `color` after `distance`. An infinite distance means no attenuation. A
// channel of 0 counts as 1e-6.
Rgb attenuation_coefficient(const Rgb& color, float distance);
Rgb beer_transmittance(const Rgb& coefficient, float distance);  // distance in scene units, >= 0

// Returns the sum of the directional albedos of reflection and transmission for a rough, white
// solid interface. TransmissionLobe divides by it. The value comes from a table over (mu,
// roughness, eta), which is built at first use (25 ms). Thread-safe.
float refraction_albedo(float mu, float roughness, float eta);

}  // namespace emberline
