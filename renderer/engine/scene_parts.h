// The light groups, Cryptomatte ids and surface roles that the settings request for a scene.
#pragma once

namespace emberline {

class CryptomatteIds;
class LightGroups;
class SurfaceRoles;

// A pointer is null if the settings request nothing of that kind. All pointers are valid until the
// scene is posed.
struct SceneParts {
  const LightGroups* light_groups = nullptr;
  const CryptomatteIds* cryptomattes = nullptr;
  const SurfaceRoles* roles = nullptr;
};

}  // namespace emberline
