// What an integrator says of one sample.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "renderer/core/vector.h"

namespace emberline {

// What the first surface along a camera ray says; filled by the integrator when AOVs ask for it.
struct FirstHit {
  bool hit = false;
  Rgb albedo = Rgb(0.0f);
  Vec3f normal = Vec3f(0.0f);  // shading normal, world axes
  Vec3f geometric_normal = Vec3f(0.0f);
  float depth = 0.0f;            // scene units along the viewing axis
  Vec3f position = Vec3f(0.0f);  // world
  Vec2f uv = Vec2f(0.0f);        // TEXCOORD_0, V upwards; 0 without
  float roughness = 0.0f;        // glTF's
  float metallic = 0.0f;
  float openness = 0.0f;  // of the hemisphere above it, 0 or 1 of a sample
  uint32_t id = 0;        // 1 + index of the instance; 0: nothing hit
  uint32_t material = 0;  // 1 + its index
  // Pixels a frame, to the right and up; finite. Where nothing was hit, that of the background.
  Vec2f velocity = Vec2f(0.0f);
};
inline bool is_finite(const FirstHit& hit) {
  return !hit.hit ||
         (is_finite(hit.albedo) && is_finite(hit.normal) && is_finite(hit.geometric_normal) &&
          std::isfinite(hit.depth) && is_finite(hit.position) && std::isfinite(hit.uv.x) &&
          std::isfinite(hit.uv.y) && std::isfinite(hit.roughness + hit.metallic));
}

// Rays traced for one sample, beside its camera ray.
struct SampleRays {
  uint32_t scatter = 0;  // continued paths
  uint32_t shadow = 0;   // visibility of sampled lights
  uint32_t total() const { return 1 + scatter + shadow; }
};

// One sample's value for one pixel, and what it cost.
struct SampleValue {
  Rgb radiance = Rgb(0.0f);
  float alpha = 0.0f;
  FirstHit first_hit = {};
  SampleRays rays = {};
  Rgb clamped = Rgb(0.0f);  // what the radiance lacks: IntegratorSettings::clamp_indirect
};

// What a sample shows: the first surface that is neither a smooth mirror nor smooth clear glass,
// seen in and through those; or the background. Every value is made to have a mean that is linear
// in what share of a pixel it covers.
struct DenoiserFeatures {
  // Directional albedo and own light, in the colours of the mirrors and glasses before it; at
  // most 1. Of the background its light.
  Rgb albedo = Rgb(0.0f);
  Vec3f normal = Vec3f(0.0f);  // shading normal, world axes; the background has none
  // One over the depth along the viewing axis, in scene units; behind mirrors that of the mirrored
  // surface. Unlike depth it is linear in the picture for a plane, and 0 for the background.
  float nearness = 0.0f;
  // 1 if the light that was sampled at the surface is seen from there.
  float visibility = 0.0f;

  static constexpr float kMostNearness = 1e6f;
};
inline constexpr size_t kFeatureValues = 8;  // as many numbers, in this order
bool is_finite(const DenoiserFeatures& features);

// What shadow catchers receive of the lights in one sample.
struct CatcherSample {
  Rgb received = Rgb(0.0f);    // irradiance from the lights, and
  Rgb unshadowed = Rgb(0.0f);  // that without what is not of the plate
  float catcher = 0.0f;        // how much of a catcher the sample sees: 1, less through panes
  float hidden = 0.0f;         // the same, if the catcher itself is not to be seen
  float background = 0.0f;     // how much of what is behind everything
};
bool is_finite(const CatcherSample& sample);

// The depth channel where no surface was hit. Finite, so that filters and viewers survive it; the
// same value Cycles writes.
inline constexpr float kBackgroundDepth = 1e10f;

}  // namespace emberline
