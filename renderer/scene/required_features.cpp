#include "renderer/scene/required_features.h"

#include <algorithm>

#include "renderer/core/errors.h"
#include "renderer/core/features.h"

namespace emberline {
namespace {

void require(bool built, bool needed, const SceneDescription& scene, const char* what) {
  if (built || !needed) return;
  throw InputError(scene.file, std::string("this program was built for plain scenes "
                                           "(EMBERLINE_PLAIN) and has no ") +
                                   what);
}

bool is_shared(const SceneDescription& scene) {
  std::vector<int> uses(scene.meshes.size(), 0);
  for (const InstanceDescription& placed : scene.instances) uses[size_t(placed.mesh)]++;
  return std::ranges::any_of(uses, [](int n) { return n > 1; });
}

}  // namespace

void require_features(const SceneDescription& scene) {
  using namespace features;
  const auto material = [&](const auto& has) { return std::ranges::any_of(scene.materials, has); };
  using M = MaterialDescription;
  require(kTextures, !scene.images.empty(), scene, "textures");
  require(kVertexColors,
          std::ranges::any_of(scene.meshes, [](const auto& m) { return !m.colors.empty(); }), scene,
          "vertex colours");
  require(kCoverage, material([](const M& m) { return m.alpha_mode != AlphaMode::kOpaque; }), scene,
          "alpha coverage");
  require(kTransmission, material([](const M& m) { return m.transmission > 0.0f; }), scene,
          "transmission");
  require(kUnlit, material([](const M& m) { return m.unlit; }), scene, "unlit materials");
  require(kInstances, is_shared(scene), scene, "instances");
  require(kPointLights, !scene.lights.empty(), scene, "punctual lights");
  require(kEnvironment, scene.environment.has_value(), scene, "environment");
}

}  // namespace emberline
