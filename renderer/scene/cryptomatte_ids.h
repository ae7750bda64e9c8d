// The ids of a scene's objects, materials and assets for Cryptomatte mattes, and their names.
//
// An object is a node that places a mesh, whatever primitives the mesh has and however often
// EXT_mesh_gpu_instancing places it; an asset is a node without a parent. Names are the file's; of
// two equal ones the later in the file gets a number ("leg", "leg_2"), and so does one whose hash
// another has. Numbers count all nodes with a mesh, so that a name stays what it is while an
// animation hides others.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "renderer/description/scene_description.h"
#include "renderer/film/cryptomatte_sums.h"

namespace emberline {

// Of a name: MurmurHash3_32, with the lowest bit of the exponent flipped where the float with these
// bits would be 0, denormal, infinite or NaN (specification 1.2, "Hash to float conversion").
uint32_t cryptomatte_id(std::string_view name);

// What a file says of one kind.
struct CryptomatteNames {
  CryptomatteKind kind = CryptomatteKind::kObject;
  std::vector<std::pair<std::string, uint32_t>> ids;  // by name; each id once

  bool operator==(const CryptomatteNames&) const = default;
};

class CryptomatteIds {
 public:
  // Of a scene that is to be built, with its nodes (GltfOptions::nodes); without nodes an object is
  // what has the instance's name.
  CryptomatteIds(const SceneDescription& scene, std::span<const CryptomatteKind> kinds);

  // One for each kind: of what FirstHit::id says, 0 the environment.
  std::span<const uint32_t> of_hit(uint32_t hit_id) const {
    return std::span(ids_).subspan(size_t(hit_id) * names_.size(), names_.size());
  }
  // By kind; of what the scene has.
  const std::vector<CryptomatteNames>& names() const { return names_; }

 private:
  std::vector<uint32_t> ids_;
  std::vector<CryptomatteNames> names_;
};

}  // namespace emberline
