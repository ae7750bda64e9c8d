// The raw vertex data of one glTF primitive, whatever it is packed in.
#pragma once

#include <optional>

#include "io/gltf_document.h"
#include "io/gltf_draco.h"

namespace emberline {

class PrimitiveReader {
 public:
  // Decodes the Draco stream if there is one. Throws InputError.
  PrimitiveReader(const GltfDocument& document, const nlohmann::json& primitive,
                  std::string pointer);

  bool has(const std::string& attribute) const;
  // vertex_count() x components floats. Throws InputError when the attribute's count differs from
  // that of POSITION.
  std::vector<float> floats(const std::string& attribute, int components) const;
  // Components of the attribute's accessor (COLOR_0 may have 3 or 4).
  int components(const std::string& attribute) const;
  // Morph target `target`; empty when it does not move this attribute.
  std::vector<float> target_floats(size_t target, const std::string& attribute,
                                   int components) const;

  uint64_t vertex_count() const { return vertex_count_; }
  // Corner indices in drawing order, checked to be below vertex_count(). Without an index accessor
  // 0, 1, 2...
  std::vector<uint32_t> indices() const;

 private:
  int accessor(const std::string& attribute) const;

  const GltfDocument& document_;
  const nlohmann::json& primitive_;
  std::string pointer_;
  std::optional<DracoPrimitive> draco_;
  uint64_t vertex_count_ = 0;
};

}  // namespace emberline
