// Tests values that are well-formed but unusable.
#include "failure/bad_input.h"

#include <limits>
#include <nlohmann/json.hpp>

namespace emberline {
namespace {

using nlohmann::json;
using test::expect_input_error;
using test::expect_warning;
using test::GltfBuilder;
using test::MemoryLimit;
using test::TempFolder;

class Absurd : public testing::Test {
 protected:
  Absurd() { gltf_.add_triangle(); }
  // The limit leaves room for the program, but not for an allocation whose size is an unchecked
  // count. Such an allocation would give the error "not enough memory", which lacks `parts`.
  void expect_error(const std::vector<std::string>& parts) {
    const MemoryLimit limit(uint64_t(4) << 30);
    expect_input_error(gltf_, parts);
  }
  TempFolder folder_;
  GltfBuilder gltf_;
};

TEST_F(Absurd, AccessorCounts) {
  gltf_.root["accessors"][0]["count"] = 4000000000u;
  expect_error({"#/accessors/0: 4000000000 elements", "do not fit"});
  gltf_.root["accessors"][0]["count"] = 9007199254740992;  // 2^53
  expect_error({"#/accessors/0: ", "do not fit"});
  gltf_.root["accessors"][0]["count"] = 18446744073709551615u;
  expect_error({"#/accessors/0/count: expected a whole number"});
}

TEST_F(Absurd, AccessorCountsWithoutData) {
  gltf_.root["accessors"][0].erase("bufferView");
  gltf_.root["accessors"][0]["count"] = 4000000000u;
  expect_error({"#/meshes/0/primitives/0/attributes/POSITION: ", "4000000000 elements"});
  gltf_.root["accessors"][0]["count"] = 3;
  gltf_.root["accessors"][1].erase("bufferView");
  gltf_.root["accessors"][1]["count"] = 4000000000u;
  expect_error({"add up to 4000000003 vertices and indices"});
}

TEST_F(Absurd, OffsetsAndLengths) {
  gltf_.root["bufferViews"][0]["byteLength"] = 1000000000000000000;  // 1e18
  expect_error({"#/bufferViews/0/byteLength: "});
  gltf_.root["bufferViews"][0]["byteLength"] = 9007199254740992;
  expect_error({"#/bufferViews/0: bytes 0 to 9007199254740992 are outside"});
  gltf_.root["bufferViews"][0] = {
      {"buffer", 0}, {"byteOffset", 9007199254740992}, {"byteLength", 9007199254740992}};
  expect_error({"#/bufferViews/0: ", "outside the buffer"});
  gltf_.root["bufferViews"][0] = {{"buffer", 0}, {"byteOffset", 0}, {"byteLength", 36}};
  gltf_.root["accessors"][0]["byteOffset"] = 9007199254740992;
  expect_error({"#/accessors/0: ", "do not fit"});
  gltf_.root["accessors"][0]["byteOffset"] = 1;
  expect_error({"#/accessors/0: ", "do not fit"});
  gltf_.root["accessors"][0]["byteOffset"] = 0;
  gltf_.root["bufferViews"][0]["byteStride"] = 8;
  expect_error({"#/accessors/0: the byteStride"});
}

TEST_F(Absurd, BufferLongerThanItsData) {
  test::write_bytes(folder_ / "data.bin", gltf_.bin);
  json document = gltf_.document("data.bin");
  document["buffers"][0]["byteLength"] = 1000000000000000;
  test::write_text(folder_ / "a.gltf", document.dump());
  expect_input_error(folder_ / "a.gltf", {"#/buffers/0/byteLength: ", "1000000000000000 bytes"});
}

TEST_F(Absurd, SparseCounts) {
  gltf_.root["accessors"][0]["sparse"] = {{"count", 4000000000u},
                                          {"indices", {{"bufferView", 1}, {"componentType", 5121}}},
                                          {"values", {{"bufferView", 0}}}};
  expect_error({"#/accessors/0/sparse/count: "});
  gltf_.root["accessors"][0]["sparse"]["count"] = 3;
  gltf_.root["accessors"][0]["sparse"]["values"]["byteOffset"] = 4;
  expect_error({"#/accessors/0/sparse/values: "});
  gltf_.root["accessors"][0]["sparse"]["values"]["byteOffset"] = 0;
  gltf_.root["accessors"][0]["sparse"]["indices"]["componentType"] = 5126;
  expect_error({"#/accessors/0/sparse/indices/componentType: "});
}

// 100 KB of JSON must not become a hundred million triangles or instances.
TEST_F(Absurd, SharedDataDoesNotMultiply) {
  const int p = gltf_.add_accessor<float>("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0});
  std::vector<uint8_t> indices(30000);
  for (size_t i = 0; i < indices.size(); ++i) indices[i] = uint8_t(i % 3);
  const int many = gltf_.add_accessor<uint8_t>("SCALAR", indices);
  for (int i = 0; i < 3000; ++i) {
    gltf_.root["meshes"][0]["primitives"].push_back(
        {{"attributes", {{"POSITION", p}}}, {"indices", many}});
  }
  expect_error({"add up to 90009006 vertices and indices"});

  GltfBuilder instanced;
  instanced.add_triangle();
  const int moves = instanced.add_accessor<float>("VEC3", std::vector<float>(3 * 3000, 1.0f));
  for (int i = 0; i < 3000; ++i) {
    instanced.add_to_scene(instanced.push(
        "nodes", {{"mesh", 0},
                  {"extensions",
                   {{"EXT_mesh_gpu_instancing", {{"attributes", {{"TRANSLATION", moves}}}}}}}}));
  }
  const MemoryLimit limit(uint64_t(4) << 30);
  expect_input_error(instanced, {"#/nodes/", "instances, too many for a file of this size"});
}

TEST_F(Absurd, NothingToRender) {
  const std::string words = "the picture shows only the environment";
  test::write_text(folder_ / "a.gltf", R"({"asset":{"version":"2.0"}})");
  expect_warning(folder_ / "a.gltf", {"nothing is visible; " + words});
  const std::pair<const char*, json> changes[] = {
      {"/scenes/0/nodes", json::array()},
      {"/nodes/0/mesh", nullptr},
      {"/meshes/0/primitives", json::array()},
      {"/nodes/0/scale", {0, 0, 0}},
      {"/nodes/0/extensions/KHR_node_visibility/visible", false},
      {"/meshes/0/primitives/0/attributes", json::object()}};
  for (const auto& [pointer, value] : changes) {
    GltfBuilder gltf = gltf_;
    const json::json_pointer place(pointer);
    gltf.root[place] = value;
    if (value.is_null()) gltf.root[place.parent_pointer()].erase(place.back());
    EXPECT_TRUE(expect_warning(gltf, {words}).instances.empty()) << pointer;
  }
  // Joints may also have a scale of zero.
  GltfBuilder skinned = gltf_;
  const int joint = skinned.push("nodes", {{"scale", {0, 0, 0}}});
  skinned.add_to_scene(joint);
  skinned.push("skins", {{"joints", {joint}}});
  skinned.root["nodes"][0]["skin"] = 0;
  skinned.primitive()["attributes"]["JOINTS_0"] =
      skinned.add_accessor<uint8_t>("VEC4", std::vector<uint8_t>(12, 0));
  skinned.primitive()["attributes"]["WEIGHTS_0"] =
      skinned.add_accessor<float>("VEC4", {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0});
  EXPECT_TRUE(expect_warning(skinned, {words}).instances.empty());
}

TEST_F(Absurd, PointsAndLinesAreNamedAndCounted) {
  gltf_.primitive().erase("indices");
  gltf_.primitive()["attributes"]["POSITION"] =
      gltf_.add_accessor<float>("VEC3", std::vector<float>(3 * 12000, 1.0f));
  const std::pair<int, const char*> modes[] = {{0, "nothing to render: 12,000 points, which"},
                                               {1, "nothing to render: 6,000 lines, which"},
                                               {2, "12,000 lines, which have no surface"},
                                               {3, "11,999 lines, which have no surface"}};
  for (const auto& [mode, words] : modes) {
    gltf_.primitive()["mode"] = mode;
    expect_error({words});
  }
  gltf_.add_mesh_node(0);
  gltf_.push("meshes", gltf_.root["meshes"][0]);
  gltf_.primitive(1)["mode"] = 0;
  gltf_.add_mesh_node(1);
  expect_error({"nothing to render: 12,000 points and 23,998 lines, which have no surface"});
  // Together with a surface, points and lines are only reported as ignored.
  gltf_.add_triangle();
  const SceneDescription scene = load_gltf(gltf_.write_glb(folder_ / "a.glb"), {});
  EXPECT_EQ(scene.coverage.ignored,
            (std::vector<std::string>{"primitive mode LINE_STRIP (has no surface)",
                                      "primitive mode POINTS (has no surface)"}));
}

TEST_F(Absurd, OnlyBadTriangles) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  gltf_.primitive() = {
      {"attributes",
       {{"POSITION", gltf_.add_accessor<float>("VEC3", {nan, 0, 0, 1, 0, 0, 0, 1, 0,  //
                                                        0, 0, 0, 1, 1, 1, 2, 2, 2})}}}};
  expect_error({"no geometry to render", "1 triangles without area",
                "1 triangles with a NaN or infinite vertex"});
  // Bad triangles do not end an animation if the scene also has a good mesh, even one whose scale
  // is zero now.
  const int good = gltf_.add_triangle();
  gltf_.root["nodes"][size_t(good)]["scale"] = {0, 0, 0};
  expect_warning(gltf_, {"1 objects scaled to zero"});
}

TEST_F(Absurd, HierarchiesOfAnyDepth) {
  // The hierarchy has 100 000 levels, each of which translates by one. The mesh is at the bottom.
  const int depth = 100000;
  json nodes = json::array();
  for (int i = 0; i < depth; ++i) {
    json node = {{"translation", {1, 0, 0}}};
    if (i + 1 < depth) {
      node["children"] = {i + 1};
    } else {
      node["mesh"] = 0;
    }
    nodes.push_back(std::move(node));
  }
  gltf_.root["nodes"] = std::move(nodes);
  const SceneDescription scene = load_gltf(gltf_.write_glb(folder_ / "a.glb"), {});
  ASSERT_EQ(scene.instances.size(), 1u);
  EXPECT_EQ(scene.instances[0].to_world[3][0], double(depth));
  // A cycle is an error, and the search for it must end.
  gltf_.root["nodes"][size_t(depth) - 1]["children"] = {0};
  expect_error({"#/nodes/", "cycle"});
}

TEST_F(Absurd, GarbageForImages) {
  std::vector<std::vector<uint8_t>> garbage = {{}, {0}, std::vector<uint8_t>(1000, 0xab)};
  // Valid file signatures followed by garbage.
  for (const std::string& magic :
       {std::string("\x89PNG\r\n\x1a\n"), std::string("\xff\xd8\xff\xe0"),
        std::string("RIFF\x20\0\0\0WEBPVP8 ", 16), std::string("\x76\x2f\x31\x01\x02\0\0\0", 8),
        std::string("#?RADIANCE\n"), std::string("\xabKTX 20\xbb\r\n\x1a\n")}) {
    std::vector<uint8_t> bytes(magic.begin(), magic.end());
    bytes.resize(300, 0x5a);
    garbage.push_back(bytes);
  }
  for (const std::vector<uint8_t>& bytes : garbage) {
    GltfBuilder gltf;
    gltf.add_triangle();
    gltf.primitive()["attributes"]["TEXCOORD_0"] =
        gltf.add_accessor<float>("VEC2", {0, 0, 1, 0, 0, 1});
    gltf.push("images", {{"uri", "image.bin"}, {"name", "g\xC3\xA4rbage"}});
    gltf.push("textures", {{"source", 0}});
    gltf.push("materials", {{"normalTexture", {{"index", 0}}}});
    gltf.primitive()["material"] = 0;
    test::write_bytes(folder_ / "image.bin", bytes);
    const std::string path = gltf.write_gltf(folder_ / "a.gltf");
    expect_input_error(path, {"#/images/0"});
    EXPECT_EQ(load_gltf(path, {.lenient = true}).repairs.replaced_images, 1u);
  }
}

TEST_F(Absurd, PathsThatAreNotFiles) {
  expect_input_error(folder_ / "missing.glb", {"file not found"});
  expect_input_error(folder_.path().string(), {"is a directory"});
  expect_input_error("/dev/null", {"is a device, not a regular file"});
  expect_input_error(std::string(300, 'x'), {"File name too long"});
}

}  // namespace
}  // namespace emberline
