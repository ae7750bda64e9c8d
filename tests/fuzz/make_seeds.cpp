// Makes seeds for the targets: make_seeds FOLDER [ASSETS]. Each target gets a folder with files
// from the tests' own builders and the small files below ASSETS.
#include <OpenColorIO/OpenColorIO.h>

#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>
#include <sstream>

#include "support/compressed_gltf.h"
#include "support/dense_gltf.h"
#include "support/encoded_images.h"
#include "support/ktx2_files.h"
#include "tests/support/embedded_images.h"

namespace fs = std::filesystem;
using namespace emberline::test;
using nlohmann::json;

namespace {

using Bytes = std::vector<uint8_t>;
constexpr size_t kLargest = size_t(16) << 10;

class Seeds {
 public:
  explicit Seeds(fs::path folder) : folder_(std::move(folder)) {}
  void add(const std::string& target, const Bytes& bytes) {
    if (bytes.size() > kLargest) return;
    write_bytes((folder_ / target / ("seed" + std::to_string(count_++))).string(), bytes);
  }
  void add(const std::string& target, const std::string& text) {
    add(target, Bytes(text.begin(), text.end()));
  }
  void add_image(const Bytes& bytes) {
    add("image", bytes);
    add("frame", bytes);
    add("environment", bytes);
  }

 private:
  fs::path folder_;
  size_t count_ = 0;
};

void add_images(Seeds& seeds) {
  for (const char* suffix : {"png", "jpg", "webp", "exr", "hdr"}) {
    const bool is_float = suffix[0] == 'e' || suffix[0] == 'h';
    for (const int channels : {1, 2, 3, 4}) {
      if (channels != 3 && (suffix[0] == 'h' || suffix[0] == 'j')) continue;
      if (channels < 3 && suffix[0] == 'w') continue;
      OIIO::ImageSpec spec(9, 7, channels,
                           is_float ? OIIO::TypeDesc::FLOAT : OIIO::TypeDesc::UINT8);
      seeds.add_image(encode_image(suffix, spec, std::vector<float>(size_t(63 * channels), 0.25f)));
    }
  }
  OIIO::ImageSpec deep(9, 7, 4, OIIO::TypeDesc::UINT16);
  seeds.add_image(encode_image("png", deep, std::vector<uint16_t>(252, 999)));
  for (const char* compression : {"none", "rle", "zip", "zips", "piz", "pxr24", "b44", "dwaa"}) {
    OIIO::ImageSpec spec(17, 11, 4, OIIO::TypeDesc::HALF);
    spec.attribute("compression", compression);
    std::vector<float> values(17 * 11 * 4);
    for (size_t i = 0; i < values.size(); ++i) values[i] = float(i % 13);
    seeds.add_image(encode_image("exr", spec, values));
    spec.tile_width = spec.tile_height = 8;
    spec.x = 3;
    spec.full_width = 24;
    spec.channelformats.assign(4, OIIO::TypeDesc::FLOAT);
    spec.channelformats[3] = OIIO::TypeDesc::UINT32;
    spec.channelnames = {"R", "G", "B", "samples"};
    seeds.add_image(encode_image("exr", spec, values));
  }
}

void add_ktx2(Seeds& seeds) {
  for (const char* name : kKtx2Files) seeds.add("image", ktx2_file(name));
}

void add_compressed(Seeds& seeds) {
  for (const int method : {0, 1}) {
    const GltfBuilder gltf = draco_square(method, true);
    seeds.add("gltf", gltf.glb());
    Bytes stream = gltf.bin;
    stream.insert(stream.end(), {3, 2, 4, 10});
    seeds.add("draco", stream);
  }
  std::vector<uint32_t> indices;
  for (uint32_t i = 0; i < 96; ++i) indices.push_back(i * 7 % 32);
  const auto add = [&](const MeshoptView& view, uint8_t mode, uint8_t filter) {
    Bytes bytes = view.encoded;
    bytes.insert(bytes.end(), {mode, filter, uint8_t(view.stride - 1), 0, uint8_t(view.count),
                               uint8_t(view.count >> 8), 0, 0});
    seeds.add("meshopt", bytes);
  };
  add(encode_indices(indices, false), 1, 0);
  add(encode_indices(indices, true), 2, 0);
  std::vector<uint16_t> values(4096);
  for (size_t i = 0; i < values.size(); ++i) values[i] = uint16_t(i * i);
  for (uint8_t filter = 0; filter < 4; ++filter) add(encode_vertices(values, 8), 0, filter);
  for (const size_t stride : {4, 12, 64, 256}) add(encode_vertices(values, stride), 0, 3);
  for (const bool sequence : {false, true}) seeds.add("gltf", meshopt_triangle(sequence).glb());
}

// Returns a scene with an archived extension that current scenes no longer use.
GltfBuilder glossy_gltf() {
  GltfBuilder gltf = dense_gltf();
  gltf.root["extensionsUsed"].push_back("KHR_materials_pbrSpecularGlossiness");
  gltf.root["materials"][0] = {{"extensions",
                                {{"KHR_materials_pbrSpecularGlossiness",
                                  {{"diffuseFactor", {0.5, 0.25, 1.0, 0.75}},
                                   {"specularFactor", {0.5, 0.5, 0.5}},
                                   {"glossinessFactor", 0.5}}}}}};
  return gltf;
}

void add_edits(Seeds& seeds) {
  seeds.add("edits", std::string(R"({"emberline_edits": 1,
    "camera": {"file_camera": {"name": "main", "index": 0}, "fov_y": 35, "look_from": [0, 1, 4],
               "look_at": [0, 0.5, 0], "up": [0, 1, 0], "mirrored": false, "f_stop": 2.8,
               "focus_distance": 4},
    "variant": {"name": "beach", "index": 1},
    "environment": {"strength": 1, "rotation": 30},
    "lights": [{"kind": "punctual", "name": "Key", "index": 0, "intensity": 2,
                "color": [1, 0.9, 0.8], "on": true},
               {"kind": "material", "name": "neon", "on": false},
               {"kind": "environment", "intensity": 0.5}],
    "materials": [{"name": "glass", "index": 3, "base_color": [1, 1, 1], "roughness": 0.1,
                   "metallic": 0, "emission": [0, 0, 0], "transmission": 1, "normal_scale": 1,
                   "ior": 1.5, "specular_color": [1, 1, 1], "attenuation_distance": 0.1,
                   "anisotropy": 0.5, "anisotropy_rotation": 30, "clearcoat": 1}]})"));
  seeds.add("edits", std::string(R"({"emberline_edits": 1, "camera": {"look_from": [0, 1, 4],
    "look_at": [0, 0, 0], "orthographic_height": 3}, "environment": {"file": "edits.json"}})"));
}

void add_displays(Seeds& seeds) {
  std::ostringstream config;
  OCIO_NAMESPACE::Config::CreateRaw()->serialize(config);
  seeds.add("display", "\n\n\n\n");
  seeds.add("display", "sRGB\nACES\n\n1.5\n");
  seeds.add("display", "sRGB\nRaw\n\n-3\n" + config.str());
}

// Adds the file to the targets that read its format. A .gltf is also added as a .glb, in which its
// first buffer becomes the binary chunk, and a small PNG replaces each image.
void add_asset(Seeds& seeds, const fs::path& path) {
  const Bytes bytes = read_bytes(path.string());
  const std::string suffix = path.extension().string();
  if (suffix == ".glb" || suffix == ".gltf") seeds.add("gltf", bytes);
  if (suffix == ".png" || suffix == ".jpg" || suffix == ".hdr" || suffix == ".exr") {
    seeds.add_image(bytes);
  }
  if (suffix == ".ktx2") seeds.add("image", bytes);
  if (suffix != ".gltf") return;
  json root = json::parse(bytes, nullptr, false);
  if (!root.is_object() || !root.contains("buffers") || root["buffers"].empty()) return;
  json& buffer = root["buffers"][0];
  if (!buffer.is_object() || !buffer.contains("uri") || !buffer["uri"].is_string()) return;
  const Bytes chunk = read_bytes((path.parent_path() / buffer["uri"].get<std::string>()).string());
  buffer.erase("uri");
  if (root.contains("images")) {
    for (json& image : root["images"]) {
      if (image.is_object()) image["uri"] = "data:image/png;base64," + base64(small_png());
    }
  }
  seeds.add("gltf", GltfBuilder::glb(root.dump(), chunk));
}

// Adds the compressed streams of a .glb.
void add_streams(Seeds& seeds, const fs::path& path) {
  const Bytes bytes = read_bytes(path.string());
  if (bytes.size() < 20) return;
  const size_t text = bytes[12] | size_t(bytes[13]) << 8 | size_t(bytes[14]) << 16;
  if (text + 28 > bytes.size()) return;
  const json root =
      json::parse(bytes.begin() + 20, bytes.begin() + 20 + std::ptrdiff_t(text), nullptr, false);
  if (!root.is_object() || !root.contains("bufferViews")) return;
  const auto slice = [&](const json& view) {
    const size_t begin = text + 28 + view.value("byteOffset", size_t(0));
    const size_t end = std::min(begin + view.value("byteLength", size_t(0)), bytes.size());
    return Bytes(bytes.begin() + std::ptrdiff_t(std::min(begin, end)),
                 bytes.begin() + std::ptrdiff_t(end));
  };
  for (const json& view : root["bufferViews"]) {
    Bytes stream = slice(view);
    if (stream.size() > 5 && std::memcmp(stream.data(), "DRACO", 5) == 0) {
      stream.insert(stream.end(), {3, 3, 2, 20});
      seeds.add("draco", stream);
    }
    if (!view.contains("extensions")) continue;
    const json& packed = view["extensions"].value("EXT_meshopt_compression", json::object());
    if (packed.empty()) continue;
    stream = slice(packed);
    const size_t count = packed.value("count", size_t(0));
    const std::string mode = packed.value("mode", "");
    stream.insert(stream.end(), {uint8_t(mode == "ATTRIBUTES"  ? 0
                                         : mode == "TRIANGLES" ? 1
                                                               : 2),
                                 0, uint8_t(packed.value("byteStride", 1) - 1), 0, uint8_t(count),
                                 uint8_t(count >> 8), uint8_t(count >> 16), 0});
    seeds.add("meshopt", stream);
  }
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc < 2) {
    std::fputs("usage: make_seeds FOLDER [ASSETS]\n", stderr);
    return 2;
  }
  Seeds seeds(argv[1]);
  seeds.add("gltf", dense_gltf().glb());
  seeds.add("gltf", dense_gltf().document("scene.gltf").dump());
  seeds.add("gltf", glossy_gltf().glb());
  add_images(seeds);
  add_ktx2(seeds);
  add_compressed(seeds);
  add_edits(seeds);
  add_displays(seeds);
  if (argc < 3) return 0;
  for (const auto& entry : fs::recursive_directory_iterator(argv[2])) {
    if (!entry.is_regular_file() || entry.file_size() > (size_t(32) << 20)) continue;
    add_asset(seeds, entry.path());
    if (entry.path().extension() == ".glb") add_streams(seeds, entry.path());
  }
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "make_seeds: %s\n", error.what());
  return 1;
}
