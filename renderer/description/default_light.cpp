#include "renderer/description/default_light.h"

#include <algorithm>

#include "renderer/core/log.h"
#include "renderer/description/scene_description.h"

namespace emberline {
namespace {

// Returns the material of a placed mesh, or null if it is the default material.
const MaterialDescription* material_of(const SceneDescription& scene,
                                       const InstanceDescription& placed) {
  const int material = scene.meshes[size_t(placed.mesh)].material;
  return material < 0 ? nullptr : &scene.materials[size_t(material)];
}

bool has_light(const SceneDescription& scene) {
  if (scene.environment || std::ranges::any_of(scene.lights, shines)) return true;
  return std::ranges::any_of(scene.instances, [&](const InstanceDescription& placed) {
    const MaterialDescription* material = material_of(scene, placed);
    const MeshDescription& mesh = scene.meshes[size_t(placed.mesh)];
    return material && emits(*material) && (mesh.reused_bounds || !mesh.triangles.empty());
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
  // A frame of an animation may hide everything. Such a frame also gets the default light, as the
  // other frames do, unless some materials are emissive or unlit.
  const bool hidden = scene.instances.empty() && scene.lights.empty() &&
                      std::ranges::none_of(scene.materials, [](const MaterialDescription& m) {
                        return m.unlit || emits(m);
                      });
  if (has_light(scene) || !(anything_lit || hidden)) return;
  log_warning(
      "the scene has no light; using a plain white environment (choose another with `env` FILE or "
      "`sun`)");
  scene.environment = EnvironmentDescription{};
}

}  // namespace emberline
