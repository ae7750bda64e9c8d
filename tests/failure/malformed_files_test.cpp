// These files are remade from the malformed files in other loaders' test collections (tinygltf's
// BoundsChecking, Assimp's glTF2, the Khronos validator's).
#include "failure/bad_input.h"

#include <limits>
#include <nlohmann/json.hpp>

namespace emberline {
namespace {

using nlohmann::json;
using test::expect_input_error;
using test::expect_warning;
using test::GltfBuilder;
using test::TempFolder;

class Malformed : public testing::Test {
 protected:
  Malformed() { gltf_.add_triangle(); }
  void expect_error(const std::vector<std::string>& parts) { expect_input_error(gltf_, parts); }

  TempFolder folder_;
  GltfBuilder gltf_;
};

TEST_F(Malformed, BufferViewLengthBeyondAllIntegers) {
  gltf_.root["bufferViews"][0]["byteLength"] = 1e300;
  expect_error({"#/bufferViews/0/byteLength: ", "1e+300"});
}

TEST_F(Malformed, BufferViewPastItsBuffer) {
  gltf_.root["bufferViews"][0]["byteLength"] = 1000;
  expect_error({"#/bufferViews/0: ", "outside the buffer of"});
}

TEST_F(Malformed, BufferIndexOutOfRange) {
  gltf_.root["bufferViews"].push_back({{"buffer", 1}, {"byteLength", 6}});
  expect_warning(gltf_, {"#/bufferViews/2/buffer: index 1 is out of range", "it is not used"});
  gltf_.root["accessors"][1]["bufferView"] = 2;
  expect_error({"#/bufferViews/2/buffer: index 1 is out of range"});
}

TEST_F(Malformed, BufferViewIndexOutOfRange) {
  gltf_.root["accessors"][0]["bufferView"] = 5;
  expect_error({"#/accessors/0/bufferView: index 5 is out of range"});
}

TEST_F(Malformed, IndicesAccessorOutOfRange) {
  gltf_.primitive()["indices"] = 7;
  expect_error({"#/meshes/0/primitives/0/indices: index 7 is out of range"});
}

TEST_F(Malformed, EmptyVersionAndOddImageUri) {
  test::write_text(folder_ / "a.gltf",
                   R"({"images":[{"uri":"%!QAAAQAAA5"}],"asset":{"version":""}})");
  expect_input_error(folder_ / "a.gltf", {"#/asset/version: ", "\"\""});
}

TEST_F(Malformed, AGlbWhoseBinChunkIsEmpty) {
  // No buffer needs the chunk, because the bytes come from elsewhere. So the file loads.
  const json document = gltf_.document("data:;base64," + test::base64(gltf_.bin));
  std::vector<uint8_t> bytes = GltfBuilder::glb(document.dump(), {});
  bytes.insert(bytes.end(), {0, 0, 0, 0, 'B', 'I', 'N', 0});
  for (int i = 0; i < 4; ++i) bytes[8 + size_t(i)] = uint8_t(bytes.size() >> (8 * i));
  test::write_bytes(folder_ / "a.glb", bytes);
  EXPECT_EQ(load_gltf(folder_ / "a.glb", {}).meshes.size(), 1u);
  // Here a buffer needs the chunk, which is empty.
  bytes = GltfBuilder::glb(gltf_.document("").dump(), {});
  bytes.insert(bytes.end(), {0, 0, 0, 0, 'B', 'I', 'N', 0});
  for (int i = 0; i < 4; ++i) bytes[8 + size_t(i)] = uint8_t(bytes.size() >> (8 * i));
  test::write_bytes(folder_ / "b.glb", bytes);
  expect_input_error(folder_ / "b.glb", {"#/buffers/0/byteLength: ", "found 0"});
}

TEST_F(Malformed, NormalsOfLengthZeroAreAccepted) {
  gltf_.primitive()["attributes"]["NORMAL"] =
      gltf_.add_accessor<float>("VEC3", std::vector<float>(9, 0.0f));
  const SceneDescription scene = load_gltf(gltf_.write_glb(folder_ / "a.glb"), {});
  EXPECT_EQ(scene.meshes[0].normals, std::vector<Vec3f>(3, Vec3f(0.0f)));
}

TEST_F(Malformed, IndexPastTheVertices) {
  gltf_.primitive()["indices"] = gltf_.add_accessor<uint16_t>("SCALAR", {0, 1, 255});
  expect_error({"#/meshes/0/primitives/0/indices: ", "is 255", "only 3 vertices"});
}

TEST_F(Malformed, MissingBinFile) {
  test::write_text(folder_ / "a.gltf", gltf_.document("Box%20Textured0.bin").dump());
  expect_input_error(folder_ / "a.gltf", {"#/buffers/0/uri: file not found", "Box Textured0.bin"});
}

TEST_F(Malformed, TwoNodesAreEachOthersChildren) {
  gltf_.root["nodes"] = {{{"children", {1}}, {"mesh", 0}}, {{"children", {0}}}};
  expect_error({"#/nodes/", "cycle"});
}

TEST_F(Malformed, PrimitivesAreNotAnArray) {
  const json primitive = gltf_.primitive();
  gltf_.root["meshes"][0]["primitives"] = {{"not an array", primitive}};
  expect_error({"#/meshes/0/primitives: expected an array, found object"});
}

TEST_F(Malformed, ANegativeTextureIndex) {
  gltf_.push("materials", {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", -1}}}}}});
  expect_warning(gltf_, {"#/materials/0/pbrMetallicRoughness/baseColorTexture/index: ", "-1"});
  gltf_.primitive()["material"] = 0;
  expect_error({"#/materials/0/pbrMetallicRoughness/baseColorTexture/index: ", "-1"});
}

TEST_F(Malformed, GlbOneByteShort) {
  std::vector<uint8_t> bytes = GltfBuilder::glb(R"({"asset":{"version":"2.0"}})", {});
  bytes.pop_back();
  test::write_bytes(folder_ / "a.glb", bytes);
  expect_input_error(folder_ / "a.glb", {"truncated GLB: 48 bytes declared, 47 found"});
}

TEST_F(Malformed, GlbOfAnotherVersion) {
  for (const uint8_t version : {uint8_t(0), uint8_t(1), uint8_t(3)}) {
    std::vector<uint8_t> bytes = gltf_.glb();
    bytes[4] = version;
    test::write_bytes(folder_ / "a.glb", bytes);
    expect_input_error(folder_ / "a.glb",
                       {"container version " + std::to_string(version) + " is not supported"});
  }
}

TEST_F(Malformed, GlbLengthThatIsTooLargeOrTooSmall) {
  std::vector<uint8_t> bytes = gltf_.glb();
  ++bytes[8];
  test::write_bytes(folder_ / "a.glb", bytes);
  expect_input_error(folder_ / "a.glb", {"truncated GLB"});
  bytes = gltf_.glb();
  bytes.push_back(0);  // trailing bytes are ignored with a warning
  test::write_bytes(folder_ / "b.glb", bytes);
  EXPECT_EQ(load_gltf(folder_ / "b.glb", {}).meshes.size(), 1u);
}

TEST_F(Malformed, GlbChunkLargerThanTheFile) {
  std::vector<uint8_t> bytes = gltf_.glb();
  bytes[8] = 13;
  bytes[9] = bytes[10] = bytes[11] = 0;
  test::write_bytes(folder_ / "a.glb", bytes);
  expect_input_error(folder_ / "a.glb", {"declares a length of 13 bytes"});
  bytes = gltf_.glb();
  bytes[15] = 0x7f;
  test::write_bytes(folder_ / "b.glb", bytes);
  expect_input_error(folder_ / "b.glb", {"chunk 0 does not fit"});
}

TEST_F(Malformed, GlbWhoseFirstChunkIsNotJson) {
  std::vector<uint8_t> bytes = gltf_.glb();
  bytes[16] = 'X';
  test::write_bytes(folder_ / "a.glb", bytes);
  expect_input_error(folder_ / "a.glb", {"first GLB chunk is not JSON"});
}

TEST_F(Malformed, EmptyFile) {
  for (const char* name : {"a.glb", "a.gltf"}) {
    test::write_text(folder_ / name, "");
    expect_input_error(folder_ / name, {"the file is empty"});
  }
}

TEST_F(Malformed, InvalidJson) {
  test::write_text(folder_ / "a.gltf", "{]");
  expect_input_error(folder_ / "a.gltf", {"not valid JSON near byte 2"});
}

TEST_F(Malformed, InfiniteAccessorElements) {
  const float inf = std::numeric_limits<float>::infinity();
  gltf_.primitive()["attributes"]["POSITION"] =
      gltf_.add_accessor<float>("VEC3", {-inf, inf, 0, 1, 0, 0, 0, 1, 0});
  expect_error({"no geometry to render", "1 triangles with a NaN or infinite vertex"});
}

TEST_F(Malformed, IndexPastTheVerticesOfAnAccessorWithoutData) {
  const int zeros =
      gltf_.push("accessors", {{"componentType", 5126}, {"count", 4}, {"type", "VEC3"}});
  gltf_.primitive() = {{"attributes", {{"POSITION", zeros}}},
                       {"indices", gltf_.add_accessor<uint8_t>("SCALAR", {0, 1, 2, 3, 4, 5})}};
  expect_error({"#/meshes/0/primitives/0/indices: ", "is 4", "only 4 vertices"});
}

TEST_F(Malformed, ARingOfThreeNodes) {
  gltf_.root["nodes"] = {{{"children", {1}}}, {{"children", {2}}}, {{"children", {0}}}};
  expect_error({"#/nodes/", "cycle"});
}

TEST_F(Malformed, ANodeWithTwoParentsOrItselfForOne) {
  gltf_.root["nodes"] = {{{"children", {2}}}, {{"children", {2}}}, {{"mesh", 0}}};
  gltf_.root["scenes"][0]["nodes"] = {0, 1};
  expect_error({"#/nodes/1/children/0: ", "another parent"});
  gltf_.root["nodes"] = {{{"children", {0}}}};
  gltf_.root["scenes"][0]["nodes"] = {0};
  expect_error({"#/nodes/0/children/0: ", "its own child"});
  gltf_.root["nodes"] = {{{"children", {1, 1}}}, json::object()};
  expect_error({"#/nodes/0/children/1: ", "listed twice"});
}

TEST_F(Malformed, AnInfiniteTransform) {
  std::string text = gltf_.document("data:;base64," + test::base64(gltf_.bin)).dump();
  text.replace(text.find("\"mesh\":0"), 8, "\"translation\":[0,1e309,-1e309],\"mesh\":0");
  test::write_text(folder_ / "a.gltf", text);
  expect_input_error(folder_ / "a.gltf", {"#/nodes/0/translation/1: ", "too large"});
}

TEST_F(Malformed, BufferNotFound) {
  test::write_text(folder_ / "a.gltf", gltf_.document("no.bin").dump());
  expect_input_error(folder_ / "a.gltf", {"#/buffers/0/uri: file not found"});
}

TEST_F(Malformed, InvalidImageData) {
  // A JPEG with invalid marker segments.
  const std::vector<uint8_t> jpeg = {0xff, 0xd8, 0xff, 0xe0, 0x00, 0x01, 0x00, 0x00, 0xff, 0xd9};
  test::write_bytes(folder_ / "bad.jpg", jpeg);
  gltf_.push("images", {{"uri", "bad.jpg"}});
  gltf_.push("textures", {{"source", 0}});
  gltf_.push("materials", {{"emissiveTexture", {{"index", 0}}}});
  gltf_.primitive()["material"] = 0;
  const std::string path = gltf_.write_gltf(folder_ / "a.gltf");
  expect_input_error(path, {"#/images/0 (bad.jpg): "});
  const SceneDescription scene = load_gltf(path, {.lenient = true});
  EXPECT_EQ(scene.repairs.replaced_images, 1u);
  EXPECT_EQ(scene.images.at(0)->width, 1);
}

TEST_F(Malformed, UnresolvedMaterial) {
  gltf_.primitive()["material"] = 0;
  expect_error({"#/meshes/0/primitives/0/material: index 0 is out of range", "0 materials"});
}

TEST_F(Malformed, FewerInverseBindMatricesThanJoints) {
  std::vector<float> matrices(32, 0.0f);
  for (size_t i = 0; i < 32; i += 5) matrices[i] = 1.0f;
  const int accessor = gltf_.add_accessor<float>("MAT4", matrices);
  gltf_.root["nodes"].push_back(json::object());
  gltf_.root["nodes"].push_back(json::object());
  for (const json& joints : {json{0}, json{0, 1}, json{0, 1, 2}}) {
    gltf_.push("skins", {{"inverseBindMatrices", accessor}, {"joints", joints}});
  }
  expect_warning(gltf_, {"#/skins/2/inverseBindMatrices: found 2 matrices for 3 joints"});
  gltf_.root["nodes"][0]["skin"] = 2;
  expect_error({"#/skins/2/inverseBindMatrices: found 2 matrices for 3 joints"});
}

TEST_F(Malformed, AMalformedDataUri) {
  test::write_text(folder_ / "a.gltf",
                   gltf_.document("data:application/octet-stream;;base64,AA==").dump());
  expect_input_error(folder_ / "a.gltf", {"#/buffers/0/uri: data URI with a malformed"});
}

TEST_F(Malformed, SparseAccessorWithUnresolvedViews) {
  gltf_.root["accessors"][0]["sparse"] = {
      {"count", 2},
      {"indices", {{"bufferView", 9}, {"byteOffset", 24}, {"componentType", 5121}}},
      {"values", {{"bufferView", 1}}}};
  expect_error({"#/accessors/0/sparse/indices/bufferView: index 9 is out of range"});
  gltf_.root["accessors"][0]["sparse"]["indices"]["bufferView"] = 1;
  expect_error({"#/accessors/0/sparse/indices: ", "do not fit into the buffer view"});
}

}  // namespace
}  // namespace emberline
