// The raw vertex data of one glTF primitive, whatever it is packed in.
#pragma once

#include <optional>

#include "io/gltf_document.h"
#include "io/gltf_draco.h"

namespace emberline {

class PrimitiveReader {
 public:
  // Decodes the Draco stream if there is one. Where it does not decode, the extension is optional
  // and the accessors have bytes, those are read. Throws InputError.
  PrimitiveReader(const GltfDocument& document, const nlohmann::json& primitive,
                  std::string pointer);

  bool has(const std::string& attribute) const;
  // Whether there is one, which is not broken.
  bool usable(const std::string& attribute) const;
  bool is_draco() const { return draco_.has_value(); }
  // Why the Draco stream was not read, if there is one.
  const std::optional<InputError>& draco_fault() const { return draco_fault_; }
  // vertex_count() x components floats. Throws InputError when the attribute's count differs from
  // that of POSITION.
  std::vector<float> floats(const std::string& attribute, int components) const;
  // Components of the attribute's accessor (COLOR_0 may have 3 or 4).
  int components(const std::string& attribute) const;
  // Morph target `target`; empty when it does not move this attribute.
  std::vector<float> target_floats(size_t target, const std::string& attribute,
                                   int components) const;

  // Those that are read: all, or, of accessors that hold far more than the primitive draws, the
  // ones that its indices name.
  uint64_t vertex_count() const { return used_.empty() ? vertex_count_ : used_.size(); }
  // Their number in the file.
  uint64_t file_vertex(size_t i) const { return used_.empty() ? i : used_[i]; }
  // Corner indices in drawing order, below vertex_count(). Without an index accessor 0, 1, 2...
  const std::vector<uint32_t>& indices() const { return indices_; }

 private:
  void read_draco(const nlohmann::json& extension);
  bool has_fallback() const;
  int accessor(const std::string& attribute) const;
  std::vector<uint32_t> read_corners() const;
  void choose_vertices();
  std::vector<float> read(int accessor, int components, const std::string& place) const;

  const GltfDocument& document_;
  const nlohmann::json& primitive_;
  std::string pointer_;
  std::optional<DracoPrimitive> draco_;
  std::optional<InputError> draco_fault_;
  uint64_t vertex_count_ = 0;  // in the file
  std::vector<uint32_t> indices_;
  std::vector<uint32_t> used_;  // growing; empty: all
};

}  // namespace emberline
