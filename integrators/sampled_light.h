// What a light that was sampled sends towards a point.
#pragma once

#include "renderer/scene/scene.h"
#include "samplers/pixel_samples.h"

namespace emberline {

// Of a point sampled on a triangle, at its brightest.
[[gnu::always_inline]] inline Rgb triangle_radiance(const Scene& scene, const LightSample& light,
                                                    const EmissiveTriangle& triangle,
                                                    const Material& material, float time,
                                                    PixelSamples& samples) {
  if (material.emits_evenly()) return material.emission();
  const SurfaceAttributes attributes = scene.emitter_attributes(triangle, time, light.barycentric);
  // A number of its own: the emitter's texel must not depend on which texel this vertex took.
  const float u_texture = material.needs_uv() ? samples.extra() : 0.0f;
  Rgb radiance = material.emission(attributes, u_texture);
  if (material.layers().clearcoat > 0.0f) {
    TexelPlaces texels;
    material.find_texels(attributes, u_texture, &texels);
    MaterialLayers layers;
    material.evaluate_layers(texels, layers);
    radiance *= emission_through_coat(layers.parameters.clearcoat,
                                      dot(light.direction, light.emitter_normal));
  }
  // A path sees the emitter only where it covers; the light sample must agree on average.
  // Decided apart from the emission, as a ray's coverage is: a card that is bright where it is
  // clear shows the product of the means.
  if (material.alpha_mode() != AlphaMode::kOpaque) {
    radiance *= material.coverage(attributes, samples.extra());
  }
  return radiance;
}

// Radiance that a sampled light sends towards the point, and whether anything blocks the way is
// the caller's question; `target` is where that question's ray ends.
inline Rgb emitted_radiance(const Scene& scene, const LightSample& light, const Vec3f& from,
                            float time, PixelSamples& samples, Vec3f* target) {
  if (light.kind != LightKind::kTriangle) {
    *target = light.position;
    return light.radiance;
  }
  const EmissiveTriangle& triangle = scene.lights().triangles()[light.index];
  *target = offset_ray_origin(light.position, light.emitter_normal,
                              scene.surface_offset(triangle.instance, triangle.primitive, time),
                              from - light.position);
  const Material& material = scene.material_of(triangle.instance);
  const Rgb radiance = triangle_radiance(scene, light, triangle, material, time, samples);
  return material.emission_changes() ? radiance * material.emission_share(time) : radiance;
}

// Share of the way to a sampled light that is clear: 0 if a surface is in between. `target` is what
// emitted_radiance() returned.
inline float transmittance(const Scene& scene, const LightSample& light, const Vec3f& from,
                           const Vec3f& target, float time, CoverageKey key) {
  if (light.distance == kInfinity) {
    return scene.transmittance_to_infinity(from, light.direction, time, key);
  }
  const float through = scene.transmittance(from, target, time, key);
  if (through == 0.0f || scene.behind_flush_emitter(from, light, time, key)) return 0.0f;
  return through;
}

}  // namespace emberline
