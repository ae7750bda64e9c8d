// Decodes the indices and attributes of one primitive (KHR_draco_mesh_compression).
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

// Throws InputError at `place` for a corrupt stream, for missing attributes, and for counts that
// are implausible for the stream's size or exceed `declared_indices` (the count of the index
// accessor) or the memory budget.
DracoPrimitive decode_draco(ByteSpan encoded, const std::vector<DracoRequest>& requests,
                            uint64_t declared_indices, const std::string& place,
                            const LoadProgress& progress = LoadProgress::none());

}  // namespace emberline
