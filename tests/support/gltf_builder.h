// Builds small glTF files at run time, right or wrong in one chosen way.
//
//   GltfBuilder gltf;
//   gltf.add_triangle();                    // a mesh of one triangle, in a node, in the scene
//   gltf.root["nodes"][0]["scale"] = {2, 2, 2};
//   SceneDescription scene = load_gltf(gltf.write_glb(folder / "a.glb"), {});
#pragma once

#include <unistd.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace emberline::test {

// A folder that is removed with all it holds when the object dies.
class TempFolder {
 public:
  TempFolder() {
    std::string pattern =
        (std::filesystem::temp_directory_path() / "emberline_test_XXXXXX").string();
    if (mkdtemp(pattern.data())) path_ = pattern;
  }
  ~TempFolder() {
    std::error_code ignored;
    if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
  }
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

inline void write_bytes(const std::string& path, const void* bytes, size_t size) {
  std::filesystem::create_directories(std::filesystem::path(path).parent_path());
  std::ofstream(path, std::ios::binary)
      .write(static_cast<const char*>(bytes), std::streamsize(size));
}
inline void write_bytes(const std::string& path, const std::vector<uint8_t>& bytes) {
  write_bytes(path, bytes.data(), bytes.size());
}
inline void write_text(const std::string& path, const std::string& text) {
  write_bytes(path, text.data(), text.size());
}
inline std::vector<uint8_t> read_bytes(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}
inline std::string read_text(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  return std::string(std::istreambuf_iterator<char>(stream), {});
}

inline std::string base64(const std::vector<uint8_t>& bytes) {
  static const char* alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    const uint32_t b0 = bytes[i], b1 = i + 1 < bytes.size() ? bytes[i + 1] : 0,
                   b2 = i + 2 < bytes.size() ? bytes[i + 2] : 0;
    const uint32_t word = b0 << 16 | b1 << 8 | b2;
    text += alphabet[word >> 18 & 63];
    text += alphabet[word >> 12 & 63];
    text += i + 1 < bytes.size() ? alphabet[word >> 6 & 63] : '=';
    text += i + 2 < bytes.size() ? alphabet[word & 63] : '=';
  }
  return text;
}

class GltfBuilder {
 public:
  using json = nlohmann::json;

  json root = {{"asset", {{"version", "2.0"}}}};
  std::vector<uint8_t> bin;  // buffer 0

  // Appends bytes to buffer 0 (aligned to 4) as a new buffer view; returns its index.
  int add_view(const void* bytes, size_t size, int stride = 0) {
    bin.resize((bin.size() + 3) / 4 * 4);
    json view = {{"buffer", 0}, {"byteOffset", bin.size()}, {"byteLength", size}};
    if (stride > 0) view["byteStride"] = stride;
    const auto* begin = static_cast<const uint8_t*>(bytes);
    bin.insert(bin.end(), begin, begin + size);
    return push("bufferViews", view);
  }

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

  // A tightly packed accessor over a view of its own; returns its index.
  template <class T>
  int add_accessor(const std::string& type, const std::vector<T>& values, bool normalized = false) {
    json accessor = {{"bufferView", add_view(values)},
                     {"componentType", component_type<T>()},
                     {"count", values.size() / component_count(type)},
                     {"type", type}};
    if (normalized) accessor["normalized"] = true;
    return push("accessors", accessor);
  }

  // Appends to a top-level array; returns the new index.
  int push(const std::string& name, const json& value) {
    root[name].push_back(value);
    return int(root[name].size()) - 1;
  }

  // A node with this mesh, listed in scene 0; returns the node.
  int add_mesh_node(int mesh) {
    const int node = push("nodes", {{"mesh", mesh}});
    add_to_scene(node);
    return node;
  }
  void add_to_scene(int node) {
    if (!root.contains("scenes")) root["scenes"] = json::array({{{"nodes", json::array()}}});
    root["scenes"][0]["nodes"].push_back(node);
  }

  // A mesh of one primitive; returns the mesh.
  int add_mesh(const json& primitive) {
    return push("meshes", {{"primitives", json::array({primitive})}});
  }

  // One triangle (0,0,0) (1,0,0) (0,1,0) in a mesh, in a node, in the scene; returns the mesh.
  int add_triangle() {
    const int positions = add_accessor<float>("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0});
    const int indices = add_accessor<uint16_t>("SCALAR", {0, 1, 2});
    const int mesh = add_mesh({{"attributes", {{"POSITION", positions}}}, {"indices", indices}});
    add_mesh_node(mesh);
    return mesh;
  }

  json& primitive(int mesh = 0) { return root["meshes"][size_t(mesh)]["primitives"][0]; }

  // The JSON with buffer 0 declared; `uri` empty: the GLB's own chunk.
  json document(const std::string& uri) const {
    json copy = root;
    if (!bin.empty()) {
      copy["buffers"][0]["byteLength"] = bin.size();
      if (!uri.empty()) copy["buffers"][0]["uri"] = uri;
    }
    return copy;
  }

  std::vector<uint8_t> glb() const { return glb(document("").dump(), bin); }

  static std::vector<uint8_t> glb(std::string text, std::vector<uint8_t> chunk) {
    while (text.size() % 4 != 0) text += ' ';
    while (chunk.size() % 4 != 0) chunk.push_back(0);
    std::vector<uint8_t> bytes;
    const auto word = [&](uint32_t value) {
      for (int shift = 0; shift < 32; shift += 8) bytes.push_back(uint8_t(value >> shift));
    };
    word(0x46546C67);
    word(2);
    word(uint32_t(12 + 8 + text.size() + (chunk.empty() ? 0 : 8 + chunk.size())));
    word(uint32_t(text.size()));
    word(0x4E4F534A);
    bytes.insert(bytes.end(), text.begin(), text.end());
    if (!chunk.empty()) {
      word(uint32_t(chunk.size()));
      word(0x004E4942);
      bytes.insert(bytes.end(), chunk.begin(), chunk.end());
    }
    return bytes;
  }

  // Each writes and returns `path`.
  std::string write_glb(const std::string& path) const {
    write_bytes(path, glb());
    return path;
  }
  std::string write_gltf(const std::string& path, const std::string& bin_name = "data.bin") const {
    write_bytes((std::filesystem::path(path).parent_path() / bin_name).string(), bin);
    write_text(path, document(bin_name).dump());
    return path;
  }
  std::string write_embedded(const std::string& path) const {
    write_text(path, document("data:application/octet-stream;base64," + base64(bin)).dump());
    return path;
  }
};

}  // namespace emberline::test
