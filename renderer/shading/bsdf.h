// The scattering function of one surface point, compiled from a material's values there.
//
// Local shading space: the shading normal is +Z, wo and wi point away from the surface and are
// unit. eval and weight include the cosine |wi.z|. Densities are per solid angle. Plain numbers
// in, plain numbers out: no sampler, no scene, no virtual call.
//
// Model (glTF 2.0 appendix B, energy-compensated): one GGX reflection lobe whose F0 mixes 0.04 and
// the base colour by metalness, over a Lambertian base weighted by what the dielectric lets
// through. See README.md for the formulas and their sources.
#pragma once

#include "renderer/core/vector.h"

namespace emberline {

// What a material says at a point.
struct BsdfParameters {
  Rgb base_color = Rgb(0.5f);
  float metallic = 0.0f;
  float roughness = 1.0f;  // glTF's: alpha = roughness^2
  // KHR_materials_ior / _specular feed these; the defaults are plain glTF.
  float ior = 1.5f;
};

struct BsdfSample {
  Vec3f wi = Vec3f(0.0f);
  Rgb weight = Rgb(0.0f);  // eval / pdf; for a delta lobe its albedo over its pick probability
  float pdf = 0.0f;        // of all lobes together; 0 with delta = true for a delta lobe
  bool delta = false;
  bool transmitted = false;  // wi is on the other side of the surface from wo
  bool valid = false;        // false: absorbed, end the path
};

class SurfaceBsdf {
 public:
  SurfaceBsdf() = default;
  // wo is fixed for a surface point, so its albedos are looked up once here. wo.z > 0.
  SurfaceBsdf(const BsdfParameters& parameters, const Vec3f& wo);

  // f(wo, wi) |wi.z|, delta lobes left out; 0 when wi.z <= 0.
  Rgb eval(const Vec3f& wi) const;
  // Density with which sample() returns wi, delta lobes left out.
  float pdf(const Vec3f& wi) const;
  // eval and pdf at the price of little more than one.
  Rgb eval_and_pdf(const Vec3f& wi, float* pdf) const;
  BsdfSample sample(float u_lobe, const Vec2f& u) const;

  // Whether next-event estimation can contribute: there is a lobe that is not a delta.
  bool has_non_delta() const { return has_non_delta_; }
  // Directional albedo estimate at wo (the `albedo` AOV: what of white light comes back).
  Rgb albedo() const;

 private:
  Vec3f wo_;
  bool has_non_delta_ = false;
  // The lobes' compiled values are added here by bsdf.cpp's author.
};

}  // namespace emberline
