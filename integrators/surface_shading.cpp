#include "integrators/surface_shading.h"

namespace emberline {

[[gnu::noinline]] void find_layers(const TexelPositions& texels, ShadedPoint* point) {
  ShadedPoint& p = *point;
  MaterialLayers layers;
  p.surface.material->evaluate_layers(texels, layers);
  LayerParameters& local = p.layers.emplace(layers.parameters);
  local.behind = p.frame.back_facing;
  const Vec3f& normal = p.surface.shading_normal;
  const Vec4f& tangent = p.surface.tangent;
  if (local.clearcoat > 0.0f) {
    const Vec3f coat = layers.has_clearcoat_normal_map
                           ? mapped_normal(normal, tangent, local.clearcoat_normal)
                           : normal;
    const SurfaceFrame frame = make_surface_frame(p.surface.geometric_normal, normal, coat, p.wo);
    local.clearcoat_normal = p.frame.shading.to_local(frame.shading.normal);
    p.material.emission *=
        emission_through_coat(local.clearcoat, dot(p.wo, p.surface.geometric_normal));
  }
  if (local.anisotropy > 0.0f) {
    const Vec3f t(tangent.x, tangent.y, tangent.z);
    const Vec3f b = cross(normal, t) * (tangent.w < 0.0f ? -1.0f : 1.0f);
    const Vec2f& along = local.anisotropy_direction;
    const Vec3f axis = p.frame.shading.to_local(fma(b, along.y, t * along.x));
    const float length = std::sqrt(fma(axis.x, axis.x, square(axis.y)));
    local.anisotropy_direction =
        length > 1e-6f ? Vec2f(axis.x / length, axis.y / length) : Vec2f(1.0f, 0.0f);
  }
}

}  // namespace emberline
