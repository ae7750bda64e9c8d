// Surfaces with a special role for camera rays: shadow catchers and holdouts.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/description/scene_description.h"

namespace emberline {

enum class SurfaceRole : uint8_t {
  kOrdinary,
  kCatcher,  // a surface of the compositor's plate that receives shadows
  kHoldout,  // an object of the plate that hides what is behind it
};

class SurfaceRoles {
 public:
  // `scene` must not have been built yet and must contain its nodes (GltfOptions::nodes). A name
  // applies to all nodes that have it. Descendants of a named node have the same role, unless they
  // are named themselves. Throws a UsageError for an unknown name (its message lists the nearest
  // names), for a node without visible geometry, and for a name in both lists.
  SurfaceRoles(const SceneDescription& scene, std::string_view catchers, std::string_view holdouts);

  SurfaceRole of(uint32_t instance) const { return roles_[instance]; }
  bool is_in_plate(uint32_t instance) const { return of(instance) != SurfaceRole::kOrdinary; }

 private:
  std::vector<SurfaceRole> roles_;  // by instance
};

// Splits "a,b" into names. In a name, `\,` stands for a comma and `\\` for a backslash.
std::vector<std::string> parse_node_names(std::string_view list);

}  // namespace emberline
