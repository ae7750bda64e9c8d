// Reads the raw vertex data of one glTF primitive, compressed or not.
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
  // Decodes the Draco stream, if there is one. If that fails, uses the accessors, provided that
  // they have data and that the extension is optional. Throws InputError.
  PrimitiveReader(const GltfDocument& document, const nlohmann::json& primitive,
                  std::string pointer);

  bool has(const std::string& attribute) const;
  // Whether the attribute exists and is not broken.
  bool is_intact(const std::string& attribute) const;
  bool is_draco() const { return draco_.has_value(); }
  // Says why the Draco stream was not used. Empty if the stream was used or if there is none.
  const std::optional<InputError>& draco_fault() const { return draco_fault_; }
  // Returns vertex_count() x components floats. Throws InputError if the attribute's count differs
  // from the count of POSITION.
  std::vector<float> floats(const std::string& attribute, int components) const;
  // Like floats(), but returns vectors and reserves capacity for `extra_capacity` more vectors.
  template <class Vector>
  std::vector<Vector> vectors(const std::string& attribute, size_t extra_capacity = 0) const {
    const int components = int(sizeof(Vector) / sizeof(float));
    check(attribute, components);
    std::vector<Vector> values;
    values.reserve(vertex_count() + extra_capacity);
    values.resize(vertex_count());  // Imath does not initialise them
    copy(attribute, components, reinterpret_cast<float*>(values.data()));
    return values;
  }
  // Number of components of the attribute's accessor (COLOR_0 may have 3 or 4).
  int components(const std::string& attribute) const;
  // Returns the displacements of morph target `target`. Empty if the target does not affect the
  // attribute.
  std::vector<float> target_floats(size_t target, const std::string& attribute,
                                   int components) const;

  // Number of vertices that are read: all vertices, or only the indexed ones if these are few.
  uint64_t vertex_count() const {
    return used_vertices_.empty() ? vertex_count_ : used_vertices_.size();
  }
  // The index that vertex `i` has in the file.
  uint64_t file_vertex(size_t i) const { return used_vertices_.empty() ? i : used_vertices_[i]; }
  // Corner indices in drawing order, all below vertex_count(). Without an index accessor: 0, 1,
  // 2...
  std::span<const uint32_t> indices() const { return {corners(), index_count_}; }
  // Moves the indices out as triangles. Drops an incomplete last triangle.
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
  const std::vector<uint32_t>* selected_vertices() const {
    return used_vertices_.empty() ? nullptr : &used_vertices_;
  }
  void check(const std::string& attribute, int components) const;
  void check_count(int accessor, const std::string& place) const;
  void copy(const std::string& attribute, int components, float* out) const;
  void select_used_vertices();
  std::vector<float> read(int accessor, int components, const std::string& place) const;

  const GltfDocument& document_;
  const nlohmann::json& primitive_;
  std::string pointer_;
  std::optional<DracoPrimitive> draco_;
  std::optional<InputError> draco_fault_;
  uint64_t vertex_count_ = 0;                       // in the file
  std::vector<std::array<uint32_t, 3>> triangles_;  // all indices; the last triangle may be partial
  uint64_t index_count_ = 0;
  std::vector<uint32_t> used_vertices_;  // ascending; empty if all are used
};

}  // namespace emberline
