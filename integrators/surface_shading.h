// Computes the surface frame and material values at a hit. All integrators that shade use this.
#pragma once

#include <optional>

#include "integrators/integrator.h"
#include "renderer/scene/camera.h"
#include "renderer/scene/scene.h"
#include "renderer/shading/bsdf.h"
#include "renderer/shading/shading_normal.h"

namespace emberline {

// A surface point ready for light transport. Vectors are in internal space.
struct ShadedPoint {
  SurfaceInteraction surface;
  SurfaceFrame frame;                     // both normals are on wo's side
  Vec3f wo;                               // towards the viewer, unit
  MaterialPoint material;                 // the material's values here
  std::optional<LayerParameters> layers;  // empty if the material has none

  [[gnu::always_inline]] SurfaceBsdf bsdf() const {
    const Vec3f local_wo = frame.shading.to_local(wo);
    const Vec3f local_normal = frame.shading.to_local(frame.geometric_normal);
    if (layers) [[unlikely]]
      return {material.bsdf, *layers, local_wo, local_normal};
    return {material.bsdf, local_wo, local_normal};
  }
  Vec3f spawn_origin(const Vec3f& direction) const {
    return offset_ray_origin(surface.position, surface.geometric_normal, surface.offset, direction);
  }
};

// Shading is split into steps (mesh, textures, material), so that code that shades many points can
// overlap their memory accesses.
inline void find_surface(const Scene& scene, const Ray& ray, const SurfaceHit& hit,
                         ShadedPoint* p) {
  scene.interaction(hit, ray.time, &p->surface);
  p->wo = -ray.direction;
}

// Each texture lookup at this point reads one texel, which the random number `u_texture` selects.
inline void find_texels(float u_texture, const ShadedPoint& p, TexelPositions* texels) {
  if (!p.surface.material->needs_uv()) return;
  p.surface.material->find_texels(p.surface.attributes, u_texture, texels);
}

// Computes the layers of a material with layers. Their directions are in local shading space.
void find_layers(const TexelPositions& texels, ShadedPoint* point);

inline void find_material(const TexelPositions& texels, ShadedPoint* point) {
  ShadedPoint& p = *point;
  p.surface.material->evaluate(p.surface.attributes, texels, p.material);
  Vec3f normal = p.surface.shading_normal;
  if (p.material.has_normal_map) {
    // The tangent's handedness already accounts for mirroring instances.
    normal = mapped_normal(normal, p.surface.tangent, p.material.normal);
  }
  p.frame = make_surface_frame(p.surface.geometric_normal, p.surface.shading_normal, normal, p.wo);
  p.material.bsdf.inside = p.frame.back_facing;
  if (p.surface.material->has_layers()) [[unlikely]]
    find_layers(texels, point);
}

inline ShadedPoint shade(const Scene& scene, const Ray& ray, const SurfaceHit& hit,
                         float u_texture) {
  ShadedPoint p;
  find_surface(scene, ray, hit, &p);
  TexelPositions texels;
  find_texels(u_texture, p, &texels);
  find_material(texels, &p);
  return p;
}

// Fills in the AOVs that the batch asks for, at the first surface of a camera ray.
inline void fill_first_hit(const SampleBatch& batch, const SurfaceHit& hit,
                           const ShadedPoint& point, float time, const Rgb& albedo, FirstHit* out) {
  if (batch.hit_id) out->id = point.surface.instance + 1;
  if (!batch.surface_aovs) return;
  out->hit = true;
  out->albedo = point.surface.material->unlit() ? point.material.emission : albedo;
  out->normal = point.frame.shading.normal;
  out->geometric_normal = point.frame.geometric_normal;
  out->depth =
      float(double(batch.camera.axial_depth(point.surface.position, time)) / batch.scene.scale());
  out->roughness = point.material.bsdf.roughness;
  out->metallic = point.material.bsdf.metallic;
  out->material = point.surface.material_index + 1;
  const Vec3d scaled_position = to_double(point.surface.position) / batch.scene.scale();
  out->position = to_float(scaled_position + batch.scene.origin());
  if (batch.scene.has_uv(point.surface.instance)) {
    const Vec2f& uv = point.surface.attributes.uv[0];
    out->uv = {uv.x, 1.0f - uv.y};
  }
  if (batch.velocity_frames == 0.0) return;
  const Scene::Motion motion = batch.scene.motion_of(hit);
  out->velocity = batch.camera.velocity(motion.from, motion.to, batch.velocity_frames);
}

}  // namespace emberline
