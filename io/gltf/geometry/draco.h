// KHR_draco_mesh_compression: one primitive's indices and attributes from a Draco stream.
#pragma once

#include <map>

#include "io/gltf/document/document.h"

namespace emberline {

struct DracoRequest {
  std::string name;  // glTF attribute semantic
  uint32_t unique_id = 0;
  int components = 0;
  bool normalized = false;
};

struct DracoPrimitive {
  uint64_t vertex_count = 0;
  std::vector<uint32_t> indices;                         // three per triangle, below vertex_count
  std::map<std::string, std::vector<float>> attributes;  // vertex_count x components each
};

// Throws InputError naming `place` for a corrupt stream, one that announces more than its size
// bears out, more than `announced_indices` or more than the memory budget of `progress` has left,
// and for missing attributes.
DracoPrimitive decode_draco(ByteSpan encoded, const std::vector<DracoRequest>& requests,
                            uint64_t announced_indices, const std::string& place,
                            const LoadProgress& progress = LoadProgress::unwatched());

}  // namespace emberline
