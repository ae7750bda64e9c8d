// What a description takes up in the world, a view of all of it, and light where it has none.
#include <algorithm>
#include <cmath>

#include "renderer/core/constants.h"
#include "renderer/core/log.h"
#include "renderer/scene/build_scene.h"
#include "renderer/scene/camera.h"

namespace emberline {
WorldBounds world_bounds(const SceneDescription& description) {
  std::vector<WorldBounds> local(description.meshes.size());
  for (size_t i = 0; i < local.size(); ++i) {
    for (const Vec3f& p : description.meshes[i].positions) {
      for (int c = 0; c < 3; ++c) {
        local[i].min[c] = std::min(local[i].min[c], double(p[c]));
        local[i].max[c] = std::max(local[i].max[c], double(p[c]));
      }
    }
  }
  WorldBounds bounds;
  for (const InstanceDescription& instance : description.instances) {
    const WorldBounds& b = local[size_t(instance.mesh)];
    if (b.empty()) continue;
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3d p = transform_point(
          instance.to_world, {corner & 1 ? b.max.x : b.min.x, corner & 2 ? b.max.y : b.min.y,
                              corner & 4 ? b.max.z : b.min.z});
      for (int c = 0; c < 3; ++c) {
        bounds.min[c] = std::min(bounds.min[c], p[c]);
        bounds.max[c] = std::max(bounds.max[c], p[c]);
      }
    }
  }
  return bounds;
}

CameraDescription framing_camera(const WorldBounds& bounds, double aspect) {
  CameraDescription camera;
  camera.name = "framing camera";
  camera.fov_y = 40.0 * kPiD / 180.0;
  const double radius = bounds.radius() > 0 ? bounds.radius() : 1.0;
  const double half = std::tan(camera.fov_y / 2) * std::min(1.0, aspect);
  const double distance = 1.05 * radius / std::sin(std::atan(half));
  const Vec3d direction = Vec3d(0.45, 0.35, 1.0).normalized();
  const Vec3d at = bounds.empty() ? Vec3d(0.0) : bounds.center();
  camera.to_world = look_at_matrix(at + direction * distance, at);
  camera.focus_distance = distance;
  return camera;
}

namespace {

bool emits(const MaterialDescription& material) {
  const auto positive = [](float x) { return x > 0.0f && std::isfinite(x); };
  const Rgb& e = material.emission;
  return !material.unlit && (positive(e.x) || positive(e.y) || positive(e.z));
}

// The material of a placed mesh, or null for the default one.
const MaterialDescription* material_of(const SceneDescription& scene,
                                       const InstanceDescription& placed) {
  const int material = scene.meshes[size_t(placed.mesh)].material;
  return material < 0 ? nullptr : &scene.materials[size_t(material)];
}

bool has_light(const SceneDescription& scene) {
  if (scene.environment) return true;
  if (std::ranges::any_of(scene.lights, [](const auto& l) { return !is_black(l.intensity); })) {
    return true;
  }
  return std::ranges::any_of(scene.instances, [&](const InstanceDescription& placed) {
    const MaterialDescription* material = material_of(scene, placed);
    return material && emits(*material) && !scene.meshes[size_t(placed.mesh)].triangles.empty();
  });
}

}  // namespace

void add_default_light(SceneDescription& scene) {
  if (scene.may_be_dark) return;
  scene.may_be_dark = true;
  const bool anything_lit =
      std::ranges::any_of(scene.instances, [&](const InstanceDescription& placed) {
        const MaterialDescription* material = material_of(scene, placed);
        return !material || !material->unlit;
      });
  if (has_light(scene) || !anything_lit) return;
  log_warning("the scene has no light; using a plain white environment (--env FILE gives another)");
  scene.environment = EnvironmentDescription{};
}

}  // namespace emberline
