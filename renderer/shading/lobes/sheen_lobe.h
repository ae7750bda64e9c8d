// The sheen of cloth (KHR_materials_sheen): the "Charlie" distribution of micro-fibre normals with
// its fitted shadowing (Estevez & Kulla 2017, "Production Friendly Microfacet Sheen BRDF"). With
// alpha = roughness^2:
//   D = (2 + 1/alpha) sin(h)^(1/alpha) / 2 pi,   f = D / (4 mu_o mu_i (1 + L(mu_o) + L(mu_i))).
// Here h is the half vector's angle to the normal, mu is a cosine, and L is the fitted shadowing.
//
// The published lobe gains energy: at cosines below 0.05, its albedo R(mu) reaches 1.19 at
// roughness 0.2 and 2.9 at roughness 0.07. At every roughness, R grows without bound towards cosine
// 0. So this class uses
//   f' = f / max(1, R(mu_o), R(mu_i)).
// The corner of the max is rounded where R differs from 1 by less than a threshold. The threshold
// is 0.15 up to roughness 0.15, and falls to 0.045 at roughness 0.285 and above. The lobe f' is
// reciprocal, has an albedo of at most 1, and equals f where f conserves energy (everywhere above
// roughness 0.285). Cosines below kSheenMinCosine are raised to that value.
//
// The cosine and the azimuth are sampled separately: the cosine with the density
// (1 + s) / (1 + s mu)^2, the azimuth with a wrapped Cauchy distribution around the azimuth of wo.
// A table of the lobe's first moments gives s and the width of the Cauchy distribution. For sample
// weights w, E[w^2] / E[w]^2 is 1.02 to 2.3 over all roughnesses and angles, and w / E[w] is at
// most 4.2. For comparison, E[w^2] / E[w]^2 is 1.04 to 18 for uniform directions and 1.2 to 140 for
// cosine-weighted ones.
#pragma once

#include "renderer/core/vector.h"
#include "renderer/shading/lobes/table_position.h"

namespace emberline {

// Lower roughnesses are raised to this value, which we chose. At 0.07, the sheen is visible only at
// cosines below 0.2, and its sample weights still vary little. At roughness 0, the sheen would be
// invisible.
inline constexpr float kSheenMinRoughness = 0.07f;
// At this cosine, R(mu) has its last minimum before R grows without bound towards cosine 0.
inline constexpr float kSheenMinCosine = 1e-4f;

struct SheenNode;

// The lobe for a white sheen colour, in local space with normal +Z. Its table (145 KiB) is built at
// first use, in 65 ms; the build is deterministic and thread-safe.
class SheenLobe {
 public:
  SheenLobe() = default;  // a black lobe; albedo() must not be called
  // `roughness` is glTF's, in [0, 1]; wo is a unit vector. The lobe is 0 unless wo.z > 0.
  SheenLobe(float roughness, const Vec3f& wo);

  float eval(const Vec3f& wi) const;   // f |wi.z|; 0 where wi.z <= 0
  float pdf(const Vec3f& wi) const;    // density of sample() per solid angle; 0 where wi.z <= 0
  Vec3f sample(const Vec2f& u) const;  // u in [0, 1)^2; wi.z > 0

  // Returns the table position of a cosine in [0, 1].
  static TablePosition column_of(float mu);
  // Returns the directional albedo at a cosine. It is in [0, 1], and its error is below 1e-3.
  float albedo(const TablePosition& column) const;
  float albedo(float mu) const { return albedo(column_of(mu)); }

 private:
  float lambda(float mu) const;  // L at a cosine in [kSheenMinCosine, 1]

  Vec3f wo_ = Vec3f(0.0f, 0.0f, 1.0f);
  Vec2f axis_ = Vec2f(1.0f, 0.0f);  // wo's azimuth
  float half_exponent_ = 1.0f;      // 1 / (2 alpha)
  float scale_ = 0.0f;              // (2 + 1/alpha) / (8 pi mu_o)
  float masking_o_ = 1.0f;          // 1 + L(mu_o)
  // Coefficients of L: log L(x) = a / (1 + b x^c) + d x + e for x < 1/2, and log L(x) =
  // 2 log L(1/2) - log L(1 - x) above that.
  float a_ = 0.0f, b_ = 0.0f, c_ = 1.0f, d_ = 0.0f, e_ = 0.0f, twice_middle_ = 0.0f;
  float limit_ = 1.0f;              // max(1, R(mu_o))
  const SheenNode* row_ = nullptr;  // table row; the next row follows it
  float row_fraction_ = 0.0f;       // towards the next row
  float round_ = 0.0f;              // distance from 1 within which the limit is rounded
  bool exceeds_one_ = false;        // R reaches the rounded part at this roughness
  float slope_ = 0.0f;              // s
  float concentration_ = 0.0f;      // of the azimuth's distribution, in [0, 1)
};

}  // namespace emberline
