// What settings name in a scene.
#pragma once

namespace emberline {

class CryptomatteIds;
class LightGroups;
class SurfaceRoles;

// Of the scene as it is built. Null: the settings name nothing of the kind.
struct SceneParts {
  const LightGroups* light_groups = nullptr;
  const CryptomatteIds* cryptomattes = nullptr;
  const SurfaceRoles* roles = nullptr;
};

}  // namespace emberline
