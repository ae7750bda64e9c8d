// Objects and lights of a scene that settings refer to.
#pragma once

namespace emberline {

class CryptomatteIds;
class LightGroups;
class SurfaceRoles;

// Null if the settings name nothing of that kind. Valid until the scene is posed.
struct SceneParts {
  const LightGroups* light_groups = nullptr;
  const CryptomatteIds* cryptomattes = nullptr;
  const SurfaceRoles* roles = nullptr;
};

}  // namespace emberline
