// Which surfaces the camera sees otherwise than other rays do: shadow catchers and holdouts.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/description/scene_description.h"

namespace emberline {

enum class SurfaceRole : uint8_t {
  kSeen,     // as any
  kCatcher,  // stands for a surface of a compositor's plate, which shows the shadows on it
  kHoldout,  // stands for something in the plate, which is in front of what is behind it
};

class SurfaceRoles {
 public:
  // Of a scene that is to be built, with its nodes (GltfOptions::nodes). A node that is named gives
  // its role to all below it but those that are named themselves; of equal names all nodes are
  // meant. Throws UsageError for a name that no node has, with the nearest ones, and for one that
  // stands for nothing that can be seen or for both.
  SurfaceRoles(const SceneDescription& scene, std::string_view catchers, std::string_view holdouts);

  SurfaceRole of(uint32_t instance) const { return roles_[instance]; }
  bool is_in_plate(uint32_t instance) const { return of(instance) != SurfaceRole::kSeen; }

 private:
  std::vector<SurfaceRole> roles_;  // by instance
};

// "a,b" -> those names; a comma in a name is written \, and a backslash \\.
std::vector<std::string> parse_node_names(std::string_view list);

}  // namespace emberline
