// Radiance and visibility of a sampled light.
#pragma once

#include "renderer/scene/scene.h"
#include "samplers/pixel_samples.h"

namespace emberline {

// Returns the radiance of a point sampled on a triangle, without the factor emission_scale().
[[gnu::always_inline]] inline Rgb triangle_radiance(const Scene& scene, const LightSample& light,
                                                    const EmissiveTriangle& triangle,
                                                    const Material& material, float time,
                                                    PixelSamples& samples) {
  if (material.has_uniform_emission()) return material.emission();
  const SurfaceAttributes attributes = scene.emitter_attributes(triangle, time, light.barycentric);
  // Use a separate random number, because the emitter's texel must not depend on this vertex's
  // texel.
  const float u_texture = material.needs_uv() ? samples.extra() : 0.0f;
  Rgb radiance = material.emission(attributes, u_texture);
  if (material.layers().clearcoat > 0.0f) {
    TexelPositions texels;
    material.find_texels(attributes, u_texture, &texels);
    MaterialLayers layers;
    material.evaluate_layers(texels, layers);
    radiance *= emission_through_coat(layers.parameters.clearcoat,
                                      dot(light.direction, light.emitter_normal));
  }
  // Paths hit only the covered part of the emitter. Multiplying the light sample by the coverage
  // gives it the same mean as the light that paths find. In both cases, the texels of coverage and
  // emission are chosen independently. So even a card that is bright only where it is transparent
  // shows the product of the mean emission and the mean coverage.
  if (material.alpha_mode() != AlphaMode::kOpaque) {
    radiance *= material.coverage(attributes, samples.extra());
  }
  return radiance;
}

// Returns the unoccluded radiance from a sampled light towards `from`. Sets `*target` to the end of
// the visibility ray that the caller must trace.
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
  return material.is_emission_animated() ? radiance * material.emission_scale(time) : radiance;
}

// Returns the transmittance towards a sampled light, or 0 if a surface blocks it. `target` comes
// from emitted_radiance().
inline float transmittance(const Scene& scene, const LightSample& light, const Vec3f& from,
                           const Vec3f& target, float time, CoverageKey key) {
  if (light.distance == kInfinity) {
    return scene.transmittance_to_infinity(from, light.direction, time, key);
  }
  const float visibility = scene.transmittance(from, target, time, key);
  if (visibility == 0.0f || scene.is_behind_flush_emitter(from, light, time, key)) return 0.0f;
  return visibility;
}

}  // namespace emberline
