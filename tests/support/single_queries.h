// Asks lights and lobes for one sample or one density at a time. The renderer asks for several
// samples at once, or for the density together with the value.
#pragma once

#include "renderer/lights/environment_light.h"
#include "renderer/lights/light_sampler.h"
#include "renderer/shading/bsdf.h"

namespace emberline::test {

inline LightSample sample_one(const LightSampler& lights, const LightQuery& query, float u_pick,
                              const Vec2f& u) {
  LightSample result;
  LightSample* const out = &result;
  const LightRequest request{query, u_pick, u};
  lights.sample({&request, 1}, &out);
  return result;
}

inline Rgb radiance_of(const EnvironmentLight& light, const Vec3f& direction) {
  Rgb result;
  light.radiance({&direction, 1}, &result);
  return result;
}

inline float pdf_of(const EnvironmentLight& light, const Vec3f& direction) {
  float result;
  light.radiance_and_pdf(direction, &result);
  return result;
}

// Returns the probability density with which a sampler without a guide samples the environment in
// `direction`.
inline float pdf_environment(const LightSampler& lights, const LightQuery& query,
                             const Vec3f& direction) {
  if (!lights.environment()) return 0.0f;
  return lights.environment_probability(query) * pdf_of(*lights.environment(), direction);
}

inline float pdf_of(const SurfaceBsdf& bsdf, const Vec3f& wi) {
  float result;
  bsdf.eval_and_pdf(wi, &result);
  return result;
}

}  // namespace emberline::test
