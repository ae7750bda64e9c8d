// The data in a frame's files that depend on the scene: names of layers, and the camera. A
// checkpoint's head also stores these data, so that the frame can be read without its scene.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "io/exr/view.h"
#include "renderer/core/vector.h"
#include "renderer/engine/scene_parts.h"
#include "renderer/scene/camera.h"
#include "renderer/scene/cryptomatte_ids.h"

namespace emberline {

struct SceneLayers {
  std::vector<std::string> lights;  // layers of --light-groups
  std::optional<ExrView::Matrices> camera;
  std::vector<CryptomatteNames> cryptomattes;
};

// Returns the layers for these parts and this camera. `origin` is the scene's origin.
SceneLayers scene_layers(const SceneParts& parts, const Camera& camera, const Vec3d& origin);

void put_scene_layers(const SceneLayers& layers, nlohmann::json& head);
// Throws an InputError that names `place` if the head, which may be arbitrary JSON, is invalid.
SceneLayers scene_layers_of(const nlohmann::json& head, const std::string& place);

}  // namespace emberline
