// Tests the ways to store a glTF: .gltf and .glb files, external, embedded and data-URI bytes, and
// paths.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "io/gltf/gltf_file.h"
#include "renderer/core/errors.h"
#include "support/embedded_images.h"

namespace emberline {
namespace {

using test::GltfBuilder;
using test::TempFolder;

TEST(GltfContainers, GlbExternalAndEmbeddedBuffersReadAlike) {
  const TempFolder folder;
  GltfBuilder gltf;
  gltf.root["asset"]["generator"] = "by hand";
  gltf.add_triangle();
  for (const std::string& path :
       {gltf.write_glb(folder / "a.glb"), gltf.write_gltf(folder / "b.gltf"),
        gltf.write_embedded(folder / "c.gltf")}) {
    const SceneDescription scene = load_gltf(path, {});
    EXPECT_EQ(scene.file, path);
    EXPECT_EQ(scene.generator, "by hand");
    ASSERT_EQ(scene.meshes.size(), 1u);
    EXPECT_EQ(scene.meshes[0].positions,
              (std::vector<Vec3f>{Vec3f(0, 0, 0), Vec3f(1, 0, 0), Vec3f(0, 1, 0)}));
    EXPECT_EQ(scene.meshes[0].triangles[0], (std::array<uint32_t, 3>{0, 1, 2}));
    ASSERT_EQ(scene.instances.size(), 1u);
    EXPECT_EQ(scene.instances[0].mesh, 0);
  }
}

TEST(GltfContainers, TheContentDecidesNotTheSuffix) {
  const TempFolder folder;
  GltfBuilder gltf;
  gltf.add_triangle();
  EXPECT_EQ(load_gltf(gltf.write_glb(folder / "binary.gltf"), {}).meshes.size(), 1u);
  EXPECT_EQ(load_gltf(gltf.write_embedded(folder / "text.glb"), {}).meshes.size(), 1u);
}

TEST(GltfContainers, GlbMayMixItsChunkWithExternalBuffersAndUnknownChunks) {
  const TempFolder folder;
  GltfBuilder gltf;
  gltf.add_triangle();
  nlohmann::json document = gltf.document("");
  document["buffers"].push_back({{"uri", "other.bin"}, {"byteLength", 36}});
  document["bufferViews"][0] = {{"buffer", 1}, {"byteLength", 36}};
  const float moved[9] = {5, 0, 0, 6, 0, 0, 5, 1, 0};
  test::write_bytes(folder / "other.bin", moved, sizeof(moved));
  std::vector<uint8_t> bytes = GltfBuilder::glb(document.dump(), gltf.bin);
  const std::vector<uint8_t> unknown = {4, 0, 0, 0, 'X', 'T', 'R', 'A', 1, 2, 3, 4};
  bytes.insert(bytes.end(), unknown.begin(), unknown.end());
  for (int i = 0; i < 4; ++i) bytes[8 + size_t(i)] = uint8_t(bytes.size() >> (8 * i));
  test::write_bytes(folder / "mixed.glb", bytes);
  const SceneDescription scene = load_gltf(folder / "mixed.glb", {});
  EXPECT_EQ(scene.meshes.at(0).positions[1], Vec3f(6, 0, 0));
}

TEST(GltfContainers, RelativePathsAndPercentEncoding) {
  const TempFolder folder;
  GltfBuilder gltf;
  gltf.add_triangle();
  test::write_bytes(folder / "data/with space & 100%.bin", gltf.bin);
  test::write_text(folder / "scenes/deep/a.gltf",
                   gltf.document("../../data/with%20space%20&%20100%25.bin").dump());
  EXPECT_EQ(
      load_gltf(folder / "scenes/deep/a.gltf", {.resource_root = folder.path()}).meshes.size(), 1u);
  // UTF-8 paths work with and without escapes.
  test::write_bytes(folder / "gr\xC3\xBCn.bin", gltf.bin);
  test::write_text(folder / "b.gltf", gltf.document("gr%C3%BCn.bin").dump());
  test::write_text(folder / "c.gltf", gltf.document("gr\xC3\xBCn.bin").dump());
  EXPECT_EQ(load_gltf(folder / "b.gltf", {}).meshes.size(), 1u);
  EXPECT_EQ(load_gltf(folder / "c.gltf", {}).meshes.size(), 1u);
}

TEST(GltfContainers, RelativeToTheWorkingDirectory) {
  const TempFolder folder;
  GltfBuilder gltf;
  gltf.add_triangle();
  gltf.write_gltf(folder / "a.gltf");
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::current_path(folder.path());
  EXPECT_EQ(load_gltf("a.gltf", {}).meshes.size(), 1u);
  std::filesystem::current_path(before);
}

TEST(GltfContainers, DataUrisOfAnyMediaType) {
  const TempFolder folder;
  GltfBuilder gltf;
  gltf.add_triangle();
  const std::string payload = test::base64(gltf.bin);
  std::string escaped;
  for (const uint8_t byte : gltf.bin) {
    const char* digits = "0123456789abcdef";
    escaped += {'%', digits[byte >> 4], digits[byte & 15]};
  }
  for (const std::string& uri :
       {"data:application/octet-stream;base64," + payload,
        "data:application/gltf-buffer;base64," + payload, "data:;base64," + payload,
        "data:text/plain;charset=utf-8;base64," + payload, "data:," + escaped}) {
    test::write_text(folder / "a.gltf", gltf.document(uri).dump());
    EXPECT_EQ(load_gltf(folder / "a.gltf", {}).meshes.size(), 1u) << uri.substr(0, 50);
  }
}

TEST(GltfContainers, ImagesFromFilesViewsAndDataUris) {
  const TempFolder folder;
  const std::vector<uint8_t> png = test::small_png();
  test::write_bytes(folder / "tex tures/a b.png", png);
  for (int kind = 0; kind < 3; ++kind) {
    GltfBuilder gltf;
    const int mesh = gltf.add_triangle();
    nlohmann::json image;
    if (kind == 0) image = {{"uri", "tex%20tures/a%20b.png"}};
    if (kind == 1) image = {{"bufferView", gltf.add_view(png)}, {"mimeType", "image/png"}};
    if (kind == 2) image = {{"uri", "data:image/png;base64," + test::base64(png)}};
    gltf.push("images", image);
    gltf.push("textures", {{"source", 0}});
    gltf.push("materials", {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}});
    gltf.primitive(mesh)["material"] = 0;
    gltf.primitive(mesh)["attributes"]["TEXCOORD_0"] =
        gltf.add_accessor<float>("VEC2", {0, 0, 1, 0, 0, 1});
    const SceneDescription scene = load_gltf(gltf.write_gltf(folder / "a.gltf"), {});
    ASSERT_EQ(scene.images.size(), 1u);
    const Image& decoded = *scene.images[0];
    EXPECT_EQ(decoded.width, 2);
    EXPECT_EQ(decoded.channels, 3);
    EXPECT_EQ(decoded.type, TexelType::kUint8);
    EXPECT_EQ(decoded.texels[0], std::byte(255));  // red, at the top left
    EXPECT_EQ(decoded.texels[1], std::byte(0));
    EXPECT_EQ(decoded.texels[4], std::byte(255));  // green, to its right
    EXPECT_EQ(scene.materials[0].base_color_texture.image, 0);
  }
}

TEST(GltfContainers, ImagesKeepTheirLiteralNames) {
  const TempFolder folder;
  GltfBuilder gltf;
  gltf.add_triangle();
  gltf.push("images", {{"uri", ""}});
  gltf.push("textures", {{"source", 0}});
  gltf.push("materials", {{"emissiveTexture", {{"index", 0}}}});
  gltf.primitive()["material"] = 0;
  const std::pair<const char*, const char*> names[] = {
      {"50%.png", "50%.png"}, {"a%20b.png", "a%20b.png"}, {"maps\\a.png", "maps/a.png"}};
  for (const auto& [uri, file] : names) {
    test::write_bytes(folder / file, test::small_png());
    gltf.root["images"][0]["uri"] = uri;
    EXPECT_EQ(load_gltf(gltf.write_glb(folder / "a.glb"), {}).images.at(0)->width, 2) << uri;
    std::filesystem::remove(folder / file);
  }
}

TEST(GltfContainers, ABrokenReferenceNamesItsPlace) {
  const TempFolder folder;
  GltfBuilder gltf;
  gltf.add_triangle();
  const std::pair<std::string, std::string> cases[] = {
      {"missing.bin", "file not found"},
      {"/etc/hostname", "absolute path"},
      {"http://example.com/a.bin", "not relative"},
      {"file:///a.bin", "not relative"},
      {"a%2.bin", "escape"},
      {"a%00b.bin", "escape"},
      {"", "empty"},
      {".", "is a directory"},
      {"data:application/octet-stream;base64", "comma"},
      {"data:application/octet-stream;;base64,AA==", "parameter"},
      {"data:a b/c;base64,AA==", "media type"},
      {"data:;base64,A", "length"},
      {"data:;base64,A===", "invalid character"},
      {"data:;base64,AA=", "padding"},
      {"data:;base64,A*==", "invalid character"},
      {"data:,%4", "escape"},
  };
  for (const auto& [uri, expected] : cases) {
    nlohmann::json document = gltf.document("x");
    document["buffers"][0]["uri"] = uri;
    test::write_text(folder / "a.gltf", document.dump());
    try {
      load_gltf(folder / "a.gltf", {});
      ADD_FAILURE() << "accepted " << uri;
    } catch (const InputError& error) {
      const std::string message = error.what();
      EXPECT_NE(message.find("a.gltf#/buffers/0/uri: "), std::string::npos) << message;
      EXPECT_NE(message.find(expected), std::string::npos) << message;
      EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    }
  }
}

TEST(GltfContainers, UnicodeByteOrderMarkAndWhiteSpaceAreAccepted) {
  const TempFolder folder;
  GltfBuilder gltf;
  gltf.add_triangle();
  const std::string uri = "data:;base64," + test::base64(gltf.bin);
  test::write_text(folder / "a.gltf", "\xEF\xBB\xBF\r\n\t " + gltf.document(uri).dump(2) + "\n\n");
  EXPECT_EQ(load_gltf(folder / "a.gltf", {}).meshes.size(), 1u);
}

}  // namespace
}  // namespace emberline
