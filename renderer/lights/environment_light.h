// A latitude-longitude environment: bilinear radiance, importance sampled exactly.
//
// u = 0.5 + atan2(z, x) / 2 pi, v = acos(y) / pi, top row +Y; u wraps, v clamps. Radiance is the
// bilinear interpolation of texels; the sampling density is the bilinear interpolation of
// per-texel weights (luminance x solid angle, MIS-compensated after Karlik et al. 2019, "MIS
// Compensation: Optimizing Sampling Techniques in Multiple Importance Sampling"), so a one-texel
// sun is sampled in proportion to what is seen of it.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "renderer/core/vector.h"

namespace emberline {

struct Image;

struct EnvironmentSample {
  Vec3f direction;
  Rgb radiance;
  float pdf = 0.0f;  // per solid angle; 0: nothing sampled
};

class EnvironmentLight {
 public:
  // Constant radiance: no table; sampled uniformly over the sphere.
  explicit EnvironmentLight(const Rgb& constant);
  // image: kHalf or kFloat, 3 channels, finite and non-negative (io guarantees it). It is shared,
  // not copied. `rotation_degrees` as in EnvironmentDescription.
  EnvironmentLight(std::shared_ptr<const Image> image, float strength, float rotation_degrees);
  ~EnvironmentLight();

  Rgb radiance(const Vec3f& direction) const;
  EnvironmentSample sample(const Vec2f& u) const;
  float pdf(const Vec3f& direction) const;

  bool black() const;       // no radiance anywhere
  float power(float scene_radius) const;  // luminance of the flux through a disk of that radius
  uint64_t bytes() const;   // tables and texels

 private:
  // Tables are added here by environment_light.cpp's author.
};

}  // namespace emberline
