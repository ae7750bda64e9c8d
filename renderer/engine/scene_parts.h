// Objects and lights that settings name in a scene.
#pragma once

namespace emberline {

class CryptomatteIds;
class LightGroups;
class SurfaceRoles;

// Null: the settings name nothing of that kind. Valid until the scene is posed.
struct SceneParts {
  const LightGroups* light_groups = nullptr;
  const CryptomatteIds* cryptomattes = nullptr;
  const SurfaceRoles* roles = nullptr;
};

}  // namespace emberline
