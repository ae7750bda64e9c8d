// What scatters at a vertex: the opaque surface, or where a material transmits, by chance the
// interface that light passes.
//
// A material is a mixture of the two, w of the interface and 1 - w of the surface. Picking one of
// them for everything that happens at the vertex (light sampling and BSDF sampling alike) has the
// mixture as its mean, and leaves each with its own densities. A material without transmission
// pays one comparison.
#pragma once

#include <variant>

#include "integrators/surface_shading.h"

namespace emberline {

class Scattering {
 public:
  Scattering(const ShadedPoint& point, PixelSamples& samples) {
    if (point.material.transmission > 0.0f && samples.extra() < point.material.transmission) {
      lobe_.emplace<TransmissionLobe>(point.transmission_lobe());
      geometric_normal_ = point.frame.shading.to_local(point.frame.geometric_normal);
    } else {
      lobe_.emplace<SurfaceBsdf>(point.bsdf());
    }
  }

  bool has_non_delta() const {
    if (const auto* bsdf = std::get_if<SurfaceBsdf>(&lobe_)) return bsdf->has_non_delta();
    return !std::get_if<TransmissionLobe>(&lobe_)->is_delta();
  }
  // Light from below the surface counts.
  bool both_sides() const { return std::holds_alternative<TransmissionLobe>(lobe_); }

  Rgb eval_and_pdf(const Vec3f& wi, float* pdf) const {
    if (const auto* bsdf = std::get_if<SurfaceBsdf>(&lobe_)) return bsdf->eval_and_pdf(wi, pdf);
    *pdf = 0.0f;
    if (!sides_agree(wi)) return Rgb(0.0f);
    return std::get_if<TransmissionLobe>(&lobe_)->eval_and_pdf(wi, pdf);
  }

  BsdfSample sample(float u_lobe, const Vec2f& u) const {
    if (const auto* bsdf = std::get_if<SurfaceBsdf>(&lobe_)) return bsdf->sample(u_lobe, u);
    BsdfSample sample = std::get_if<TransmissionLobe>(&lobe_)->sample(u_lobe, u);
    sample.valid = sample.valid && sides_agree(sample.wi);
    return sample;
  }

  Rgb albedo() const {
    if (const auto* bsdf = std::get_if<SurfaceBsdf>(&lobe_)) return bsdf->albedo();
    return std::get_if<TransmissionLobe>(&lobe_)->albedo();
  }

 private:
  // Shading and geometric normal must see wi on the same side, or light would leak through.
  bool sides_agree(const Vec3f& wi) const {
    return wi.z > 0.0f ? dot(wi, geometric_normal_) > 0.0f : dot(wi, geometric_normal_) < 0.0f;
  }

  std::variant<SurfaceBsdf, TransmissionLobe> lobe_;
  Vec3f geometric_normal_;
};

}  // namespace emberline
