// The result of one sample.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "renderer/core/vector.h"

namespace emberline {

// The first surface along a camera ray; the integrator fills this in if the AOVs need it.
struct FirstHit {
  bool hit = false;
  Rgb albedo = Rgb(0.0f);
  Vec3f normal = Vec3f(0.0f);  // shading normal, world axes
  Vec3f geometric_normal = Vec3f(0.0f);
  float depth = 0.0f;            // scene units along the viewing axis
  Vec3f position = Vec3f(0.0f);  // world
  Vec2f uv = Vec2f(0.0f);        // TEXCOORD_0, V upwards; 0 if absent
  float roughness = 0.0f;        // as in glTF
  float metallic = 0.0f;
  float ambient_visibility = 0.0f;  // 1 if a random direction above the surface is open, else 0
  uint32_t id = 0;                  // 1 + instance index; 0: no hit
  uint32_t material = 0;            // 1 + material index
  // In pixels per frame, to the right and up; finite. The background's velocity if nothing was hit.
  Vec2f velocity = Vec2f(0.0f);
  // The motion of what is seen in mirrors and through glass, minus `velocity`; finite.
  Vec2f specular_velocity = Vec2f(0.0f);
};
inline bool is_finite(const FirstHit& hit) {
  return !hit.hit ||
         (is_finite(hit.albedo) && is_finite(hit.normal) && is_finite(hit.geometric_normal) &&
          std::isfinite(hit.depth) && is_finite(hit.position) && std::isfinite(hit.uv.x) &&
          std::isfinite(hit.uv.y) && std::isfinite(hit.roughness + hit.metallic));
}

// Rays traced for one sample, in addition to its camera ray.
struct SampleRays {
  uint32_t scatter = 0;  // continued paths
  uint32_t shadow = 0;   // visibility of sampled lights
  uint32_t total() const { return 1 + scatter + shadow; }
};

// The value of one sample and its cost.
struct SampleValue {
  Rgb radiance = Rgb(0.0f);
  float alpha = 0.0f;
  FirstHit first_hit = {};
  SampleRays rays = {};
  Rgb clamped = Rgb(0.0f);  // radiance removed by IntegratorSettings::clamp_indirect
};

// Denoiser features of a sample. They describe the first surface that is neither a smooth mirror
// nor smooth clear glass, or the background. The mean of each value over a pixel is linear in the
// fraction of the pixel that a surface covers.
struct DenoiserFeatures {
  // Directional albedo plus emission, tinted by the mirrors and glass in front of the surface; at
  // most 1. If no surface is seen, this is the background's radiance.
  Rgb albedo = Rgb(0.0f);
  Vec3f normal = Vec3f(0.0f);  // shading normal, world axes; 0 for the background
  // 1 / depth along the viewing axis (scene units). For a surface seen in mirrors, the depth is
  // that of its mirror image. Unlike depth, nearness is linear in the image for a plane, and 0 for
  // the background.
  float nearness = 0.0f;
  // 1 if the sampled light is visible from the surface.
  float visibility = 0.0f;

  static constexpr float kMaxNearness = 1e6f;
};
inline constexpr size_t kFeatureValues = 8;  // the values above, in this order
bool is_finite(const DenoiserFeatures& features);

// Light received by shadow catchers in one sample.
struct CatcherSample {
  Rgb received = Rgb(0.0f);    // irradiance from the lights
  Rgb unshadowed = Rgb(0.0f);  // the same if only catchers and holdouts blocked light
  float catcher = 0.0f;        // how much of a catcher the sample sees: 1, or less through glass
  float hidden = 0.0f;         // equal to `catcher` if the catcher is not rendered, else 0
  float background = 0.0f;     // how much of the background the sample sees
};
bool is_finite(const CatcherSample& sample);

// Depth where no surface was hit. It is finite because filters and viewers need a finite depth.
// Cycles writes the same value.
inline constexpr float kBackgroundDepth = 1e10f;

}  // namespace emberline
