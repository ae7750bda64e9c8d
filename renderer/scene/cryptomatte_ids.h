// Cryptomatte ids and names of a scene's objects, materials and assets.
//
// An object is a node with a mesh; it includes all primitives of the mesh and all its
// EXT_mesh_gpu_instancing copies. An asset is a node without a parent. Names come from the file. If
// two names are identical, the later one in the file gets a number ("leg", "leg_2"), and so does a
// name whose hash is already taken. Numbering counts all nodes with a mesh, so that names stay the
// same while an animation hides nodes.
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

// Returns the id of a name. This is its MurmurHash3_32. If the float with these bits would be 0,
// denormal, infinite or NaN, the lowest exponent bit is flipped (specification 1.2, "Hash to float
// conversion").
uint32_t cryptomatte_id(std::string_view name);

// The names and ids of one kind of entity.
struct CryptomatteNames {
  CryptomatteKind kind = CryptomatteKind::kObject;
  std::vector<std::pair<std::string, uint32_t>> ids;  // each id once, in no particular order

  bool operator==(const CryptomatteNames&) const = default;
};

class CryptomatteIds {
 public:
  // `scene` must not have been built yet and should contain its nodes (GltfOptions::nodes); without
  // nodes, instances with the same name are one object.
  CryptomatteIds(const SceneDescription& scene, std::span<const CryptomatteKind> kinds);

  // Returns the ids that belong to a FirstHit::id (0: the environment), one per kind of entity.
  std::span<const uint32_t> ids_of_hit(uint32_t hit_id) const {
    return std::span(ids_).subspan(size_t(hit_id) * names_.size(), names_.size());
  }
  // Contains one entry per kind, which lists only names that the scene uses.
  const std::vector<CryptomatteNames>& names() const { return names_; }

 private:
  std::vector<uint32_t> ids_;
  std::vector<CryptomatteNames> names_;
};

}  // namespace emberline
