// The raw vertex data of one glTF primitive, whatever it is packed in.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "io/gltf/document/document.h"
#include "io/gltf/geometry/draco.h"

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
  // The same as vectors, with room for so many more.
  template <class Vector>
  std::vector<Vector> vectors(const std::string& attribute, size_t spare = 0) const {
    const int components = int(sizeof(Vector) / sizeof(float));
    check(attribute, components);
    std::vector<Vector> values;
    values.reserve(vertex_count() + spare);
    values.resize(vertex_count());  // Imath leaves them as they are: nobody touches them twice
    copy(attribute, components, reinterpret_cast<float*>(values.data()));
    return values;
  }
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
  std::span<const uint32_t> indices() const { return {corners(), index_count_}; }
  // They, three by three, as a list of triangles; a rest makes none. There are none afterwards.
  std::vector<std::array<uint32_t, 3>> take_triangles();

 private:
  void read_draco(const nlohmann::json& extension);
  bool has_fallback() const;
  int accessor(const std::string& attribute) const;
  void read_corners();
  void set_index_count(uint64_t count);
  const uint32_t* corners() const { return triangles_.empty() ? nullptr : triangles_[0].data(); }
  uint32_t* corners() { return triangles_.empty() ? nullptr : triangles_[0].data(); }
  std::string place_of(const std::string& attribute) const;
  const std::vector<float>* draco_floats(const std::string& attribute) const;
  const std::vector<uint32_t>* chosen() const { return used_.empty() ? nullptr : &used_; }
  void check(const std::string& attribute, int components) const;
  void check_count(int accessor, const std::string& place) const;
  void copy(const std::string& attribute, int components, float* out) const;
  void choose_vertices();
  std::vector<float> read(int accessor, int components, const std::string& place) const;

  const GltfDocument& document_;
  const nlohmann::json& primitive_;
  std::string pointer_;
  std::optional<DracoPrimitive> draco_;
  std::optional<InputError> draco_fault_;
  uint64_t vertex_count_ = 0;                       // in the file
  std::vector<std::array<uint32_t, 3>> triangles_;  // all indices, and what is left of the last
  uint64_t index_count_ = 0;
  std::vector<uint32_t> used_;  // growing; empty: all
};

}  // namespace emberline
