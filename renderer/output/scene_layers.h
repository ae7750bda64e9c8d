// What of a frame's files is known only once its scene is: names, and where the camera stands. A
// checkpoint's head has it, too, for those who read the frame without its scene.
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

// Of a frame of these parts, through this camera. `origin` is the scene's.
SceneLayers scene_layers(const SceneParts& parts, const Camera& camera, const Vec3d& origin);

void put_scene_layers(const SceneLayers& layers, nlohmann::json& head);
// Throws InputError that names `place`: anything may stand in a head.
SceneLayers scene_layers_of(const nlohmann::json& head, const std::string& place);

}  // namespace emberline
