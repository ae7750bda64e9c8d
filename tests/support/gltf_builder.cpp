#include "support/gltf_builder.h"

#include <filesystem>
#include <nlohmann/json.hpp>

namespace emberline::test {

std::string base64(const std::vector<uint8_t>& bytes) {
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

GltfBuilder::GltfBuilder()
    : value_(json::object({{"asset", {{"version", "2.0"}}}})), root(*value_) {}

GltfBuilder::GltfBuilder(const GltfBuilder& other)
    : value_(other.value_), root(*value_), bin(other.bin) {}

GltfBuilder& GltfBuilder::operator=(const GltfBuilder& other) {
  root = other.root;
  bin = other.bin;
  return *this;
}

int GltfBuilder::add_view(const void* bytes, size_t size, int stride) {
  bin.resize((bin.size() + 3) / 4 * 4);
  json view = {{"buffer", 0}, {"byteOffset", bin.size()}, {"byteLength", size}};
  if (stride > 0) view["byteStride"] = stride;
  const auto* begin = static_cast<const uint8_t*>(bytes);
  bin.insert(bin.end(), begin, begin + size);
  return push("bufferViews", view);
}

int GltfBuilder::add_accessor_for_view(int view, int component_type, size_t count,
                                       const std::string& type, bool normalized) {
  json accessor = {
      {"bufferView", view}, {"componentType", component_type}, {"count", count}, {"type", type}};
  if (normalized) accessor["normalized"] = true;
  return push("accessors", accessor);
}

int GltfBuilder::push(const std::string& name, const json& value) {
  root[name].push_back(value);
  return int(root[name].size()) - 1;
}

int GltfBuilder::add_mesh_node(int mesh) {
  const int node = push("nodes", {{"mesh", mesh}});
  add_to_scene(node);
  return node;
}

void GltfBuilder::add_to_scene(int node) {
  if (!root.contains("scenes")) root["scenes"] = json::array({{{"nodes", json::array()}}});
  root["scenes"][0]["nodes"].push_back(node);
}

int GltfBuilder::add_mesh(const json& primitive) {
  return push("meshes", {{"primitives", json::array({primitive})}});
}

int GltfBuilder::add_triangle() {
  const int positions = add_accessor<float>("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0});
  const int indices = add_accessor<uint16_t>("SCALAR", {0, 1, 2});
  const int mesh = add_mesh({{"attributes", {{"POSITION", positions}}}, {"indices", indices}});
  add_mesh_node(mesh);
  return mesh;
}

nlohmann::json& GltfBuilder::primitive(int mesh) {
  return root["meshes"][size_t(mesh)]["primitives"][0];
}

nlohmann::json GltfBuilder::document(const std::string& uri) const {
  json copy = root;
  if (!bin.empty()) {
    copy["buffers"][0]["byteLength"] = bin.size();
    if (!uri.empty()) copy["buffers"][0]["uri"] = uri;
  }
  return copy;
}

std::vector<uint8_t> GltfBuilder::glb() const { return glb(document("").dump(), bin); }

std::vector<uint8_t> GltfBuilder::glb(std::string text, std::vector<uint8_t> chunk) {
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

std::string GltfBuilder::write_glb(const std::string& path) const {
  write_bytes(path, glb());
  return path;
}

std::string GltfBuilder::write_gltf(const std::string& path, const std::string& bin_name) const {
  write_bytes((std::filesystem::path(path).parent_path() / bin_name).string(), bin);
  write_text(path, document(bin_name).dump());
  return path;
}

std::string GltfBuilder::write_embedded(const std::string& path) const {
  write_text(path, document("data:application/octet-stream;base64," + base64(bin)).dump());
  return path;
}

}  // namespace emberline::test
