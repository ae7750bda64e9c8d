// In these small files many objects share data. The cost of loading must grow linearly with the
// file's size, not quadratically.
#include <nlohmann/json.hpp>

#include "failure/bad_input.h"
#include "renderer/core/log.h"
#include "support/processor_time.h"

namespace emberline {
namespace {

using nlohmann::json;
using test::GltfBuilder;
using test::MemoryLimit;
using test::TempFolder;

// Returns the seconds of processor time to load the file. There is enough memory for the program,
// but not for a copy of the data for each use.
double load_seconds(const GltfBuilder& gltf) {
  const TempFolder folder;
  const std::string path = gltf.write_glb(folder / "a.glb");
  const MemoryLimit limit(uint64_t(4) << 30);
  const double start = test::processor_seconds();
  EXPECT_FALSE(load_gltf(path, {}).instances.empty());
  return test::processor_seconds() - start;
}

// Quadratic behaviour would take a minute or more of processor time, or exhaust the memory.
// Sanitizers need part of the ten seconds.
constexpr double kMost = 10.0;

TEST(SharedData, NodesInOneSkin) {
  constexpr int kCount = 8000;
  GltfBuilder gltf;
  const int mesh = gltf.add_triangle();
  json& attributes = gltf.primitive(mesh)["attributes"];
  attributes["JOINTS_0"] = gltf.add_accessor<uint8_t>("VEC4", std::vector<uint8_t>(12, 0));
  attributes["WEIGHTS_0"] = gltf.add_accessor<float>("VEC4", std::vector<float>(12, 0.25f));
  json joints = json::array();
  for (int i = 0; i < kCount; ++i) {
    const int node = gltf.add_mesh_node(mesh);
    gltf.root["nodes"][size_t(node)]["skin"] = 0;
    joints.push_back(node);
  }
  gltf.push("skins", {{"joints", joints}});
  EXPECT_LT(load_seconds(gltf), kMost);
}

TEST(SharedData, NodesWithTheWeightsOfTheirMesh) {
  constexpr int kCount = 30000;
  GltfBuilder gltf;
  const int mesh = gltf.add_triangle();
  gltf.root["meshes"][0]["weights"] = std::vector<double>(kCount, 0.0);
  gltf.primitive(mesh)["targets"] = std::vector<json>(kCount, json::object());
  for (int i = 0; i < kCount; ++i) gltf.add_mesh_node(mesh);
  EXPECT_LT(load_seconds(gltf), kMost);
}

TEST(SharedData, TrianglesOfOneVertexBuffer) {
  GltfBuilder gltf;
  const int mesh = gltf.add_triangle();
  std::vector<float> positions(3 * 500000);
  for (size_t i = 0; i < positions.size(); ++i) positions[i] = float(i % 7);
  const int p = gltf.add_accessor<float>("VEC3", positions);
  const json triangle = {{"attributes", {{"POSITION", p}}}, {"indices", 1}};
  for (int i = 0; i < 20000; ++i)
    gltf.root["meshes"][size_t(mesh)]["primitives"].push_back(triangle);
  EXPECT_LT(load_seconds(gltf), kMost);
}

TEST(SharedData, MorphTargetsOfOneAccessor) {
  GltfBuilder gltf;
  const int mesh = gltf.add_mesh(
      {{"attributes",
        {{"POSITION", gltf.add_accessor<float>("VEC3", std::vector<float>(3 * 100000, 1.0f))}}}});
  gltf.add_mesh_node(mesh);
  gltf.root["meshes"][0]["weights"] = std::vector<double>(20000, 1.0);
  gltf.primitive(mesh)["targets"] = std::vector<json>(20000, {{"POSITION", 0}});
  test::expect_input_error(gltf, {"vertices and indices, too many for a file of this size"});
}

TEST(SharedData, NamesOfUnknownExtensions) {
  GltfBuilder gltf;
  gltf.add_triangle();
  json& names = gltf.root["extensionsUsed"];
  for (int i = 0; i < 200000; ++i) names.push_back("EXT_of_nobody_" + std::to_string(i));
  set_log_level(LogLevel::kQuiet);
  EXPECT_LT(load_seconds(gltf), kMost);
  set_log_level(LogLevel::kNormal);
}

// Hundreds of objects share a name of one megabyte.
TEST(SharedData, CopiedNamesCountAgainstTheLimit) {
  const std::string name(size_t(1) << 20, 'n');
  constexpr int kCount = 200;
  GltfBuilder cameras, lamps, meshes, nodes;
  for (GltfBuilder* gltf : {&cameras, &lamps, &meshes, &nodes}) gltf->add_triangle();
  cameras.push(
      "cameras",
      {{"name", name}, {"type", "perspective"}, {"perspective", {{"yfov", 1.0}, {"znear", 0.1}}}});
  lamps.root["extensionsUsed"] = {"KHR_lights_punctual"};
  lamps.root["extensions"]["KHR_lights_punctual"]["lights"] = {{{"name", name}, {"type", "point"}}};
  meshes.root["meshes"][0]["name"] = name;
  nodes.root["extensionsUsed"] = {"EXT_mesh_gpu_instancing"};
  const int places = nodes.add_accessor<float>("VEC3", std::vector<float>(3 * kCount, 1.0f));
  const int node = nodes.add_mesh_node(0);
  nodes.root["nodes"][size_t(node)]["name"] = name;
  nodes.root["nodes"][size_t(node)]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
      {"TRANSLATION", places}};
  for (int i = 0; i < kCount; ++i) {
    json& camera = cameras.root["nodes"][size_t(cameras.add_mesh_node(0))];
    camera["camera"] = 0;
    json& lamp = lamps.root["nodes"][size_t(lamps.add_mesh_node(0))];
    lamp["extensions"]["KHR_lights_punctual"]["light"] = 0;
    meshes.root["meshes"][0]["primitives"].push_back(meshes.primitive(0));
  }
  for (const GltfBuilder* gltf : {&cameras, &lamps, &meshes, &nodes}) {
    EXPECT_NE(test::rejection_message(*gltf, uint64_t(100) << 20).find("raise memory-limit"),
              std::string::npos);
    EXPECT_EQ(test::rejection_message(*gltf, uint64_t(1) << 30), "no error");
  }
}

// Gathering the placements takes more than half of their memory before the first instance exists.
TEST(SharedData, PlacementsCountAgainstTheLimitWhileGathered) {
  constexpr int kCount = 10000;
  GltfBuilder gltf;
  const int mesh = gltf.add_triangle();
  const int places = gltf.add_accessor<float>("VEC3", std::vector<float>(3 * kCount, 1.0f));
  gltf.root["extensionsUsed"] = {"EXT_mesh_gpu_instancing"};
  for (int i = 0; i < 20; ++i) {
    json& node = gltf.root["nodes"][size_t(gltf.add_mesh_node(mesh))];
    node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {{"TRANSLATION", places}};
  }
  // There are 200,000 placements of 144 bytes.
  const std::string message = test::rejection_message(gltf, uint64_t(20) << 20);
  EXPECT_NE(message.find("#/nodes/1"), std::string::npos) << message;
  EXPECT_EQ(test::rejection_message(gltf, uint64_t(128) << 20), "no error");
}

}  // namespace
}  // namespace emberline
