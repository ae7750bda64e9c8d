// Builds small glTF files at run time, either valid or with a chosen error.
//
//   GltfBuilder gltf;
//   gltf.add_triangle();                    // adds a mesh of one triangle and its node
//   gltf.root["nodes"][0]["scale"] = {2, 2, 2};
//   SceneDescription scene = load_gltf(gltf.write_glb(folder / "a.glb"), {});
//
// Source files that use `root` must include nlohmann/json.hpp.
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <type_traits>
#include <vector>

#include "io/json/value.h"
#include "support/temp_folder.h"

namespace emberline::test {

std::string base64(const std::vector<uint8_t>& bytes);

class GltfBuilder {
  JsonValue value_;  // contains the JSON that `root` refers to

 public:
  using json = nlohmann::json;

  GltfBuilder();
  GltfBuilder(const GltfBuilder& other);
  GltfBuilder& operator=(const GltfBuilder& other);

  json& root;
  std::vector<uint8_t> bin;  // buffer 0

  // Appends bytes to buffer 0, aligned to 4. Adds a buffer view for them and returns its index.
  int add_view(const void* bytes, size_t size, int stride = 0);

  template <class T>
  int add_view(const std::vector<T>& values, int stride = 0) {
    return add_view(values.data(), values.size() * sizeof(T), stride);
  }

  template <class T>
  static constexpr int component_type() {
    if constexpr (std::is_same_v<T, int8_t>) return 5120;
    if constexpr (std::is_same_v<T, uint8_t>) return 5121;
    if constexpr (std::is_same_v<T, int16_t>) return 5122;
    if constexpr (std::is_same_v<T, uint16_t>) return 5123;
    if constexpr (std::is_same_v<T, uint32_t>) return 5125;
    return 5126;
  }

  static size_t component_count(const std::string& type) {
    if (type == "SCALAR") return 1;
    if (type == "MAT4") return 16;
    return size_t(type.back() - '0');
  }

  // Adds a tightly packed accessor with a new view. Returns the index of the accessor.
  template <class T>
  int add_accessor(const std::string& type, const std::vector<T>& values, bool normalized = false) {
    return add_accessor_for_view(add_view(values), component_type<T>(),
                                 values.size() / component_count(type), type, normalized);
  }
  // Adds an accessor to an existing view. Returns the index of the accessor.
  int add_accessor_for_view(int view, int component_type, size_t count, const std::string& type,
                            bool normalized);

  // Appends `value` to the top-level array `name`. Returns its index.
  int push(const std::string& name, const json& value);

  // Adds a node with this mesh to scene 0. Returns the index of the node.
  int add_mesh_node(int mesh);
  void add_to_scene(int node);

  // Adds a mesh with one primitive. Returns the index of the mesh.
  int add_mesh(const json& primitive);

  // Adds a mesh of one triangle (0,0,0) (1,0,0) (0,1,0), and a node with this mesh to scene 0.
  // Returns the index of the mesh.
  int add_triangle();

  json& primitive(int mesh = 0);

  // Returns the JSON of the file. Its buffer 0 has this URI, or is the chunk of a GLB file if `uri`
  // is empty.
  json document(const std::string& uri) const;

  std::vector<uint8_t> glb() const;
  static std::vector<uint8_t> glb(std::string text, std::vector<uint8_t> chunk);

  // These functions write the file and return `path`.
  std::string write_glb(const std::string& path) const;
  std::string write_gltf(const std::string& path, const std::string& bin_name = "data.bin") const;
  std::string write_embedded(const std::string& path) const;
};

}  // namespace emberline::test
