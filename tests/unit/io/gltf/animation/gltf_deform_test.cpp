// Tests morph targets and skins at rest.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "support/loaded_gltf.h"

namespace emberline {
namespace {

using nlohmann::json;
using test::GltfBuilder;
using test::load;
using test::message_of;

Vec3d world_position(const SceneDescription& scene, size_t instance, size_t vertex) {
  const InstanceDescription& i = scene.instances.at(instance);
  Vec3d out;
  i.to_world.multVecMatrix(Vec3d(scene.meshes[size_t(i.mesh)].positions.at(vertex)), out);
  return out;
}

void expect_close(const Vec3d& a, const Vec3d& b, double tolerance = 1e-6) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], tolerance) << a << " against " << b;
}

TEST(GltfDeform, MorphTargetsFollowTheWeightsOfTheMeshOrTheNode) {
  GltfBuilder gltf;
  const int mesh = gltf.add_triangle();
  const int lift = gltf.add_accessor<float>("VEC3", {0, 0, 1, 0, 0, 1, 0, 0, 1});
  const int tilt = gltf.add_accessor<float>("VEC3", {0, 0, 0, 0, 0, 4, 0, 0, 0});
  gltf.primitive(mesh)["attributes"]["NORMAL"] =
      gltf.add_accessor<float>("VEC3", {0, 0, 1, 0, 0, 1, 0, 0, 1});
  const int lean = gltf.add_accessor<float>("VEC3", {4, 0, 0, 0, 0, 0, 0, 0, 0});
  gltf.primitive(mesh)["targets"] = {{{"POSITION", lift}}, {{"POSITION", tilt}, {"NORMAL", lean}}};
  // Without weights, the targets move nothing at rest.
  SceneDescription scene = load(gltf);
  EXPECT_EQ(scene.meshes[0].positions[1], Vec3f(1, 0, 0));
  ASSERT_EQ(scene.coverage.approximated.size(), 1u);
  EXPECT_EQ(scene.coverage.approximated[0].rfind("morph targets", 0), 0u);

  gltf.root["meshes"][0]["weights"] = {0.5, 0.25};
  scene = load(gltf);
  EXPECT_EQ(scene.meshes[0].positions[0], Vec3f(0, 0, 0.5f));
  EXPECT_EQ(scene.meshes[0].positions[1], Vec3f(1, 0, 1.5f));
  const float h = std::sqrt(0.5f);
  EXPECT_NEAR(scene.meshes[0].normals[0].x, h, 1e-6f);
  EXPECT_NEAR(scene.meshes[0].normals[0].z, h, 1e-6f);

  // The weights of a node take precedence over those of the mesh, and give the node a mesh of its
  // own.
  gltf.add_mesh_node(mesh);
  gltf.root["nodes"][1]["weights"] = {2, 0};
  scene = load(gltf);
  ASSERT_EQ(scene.meshes.size(), 2u);
  EXPECT_EQ(scene.meshes[size_t(scene.instances[1].mesh)].positions[0], Vec3f(0, 0, 2));
  gltf.root["nodes"][1]["weights"] = {2, 0, 1};
  EXPECT_NE(message_of(gltf).find("3 weights, but only 2 morph targets"), std::string::npos);
}

TEST(GltfDeform, ATargetMustHaveItsMeshsVertices) {
  GltfBuilder gltf;
  const int mesh = gltf.add_triangle();
  gltf.primitive(mesh)["targets"] = {
      {{"POSITION", gltf.add_accessor<float>("VEC3", {0, 0, 1, 0, 0, 1})}}};
  gltf.root["meshes"][0]["weights"] = {1};
  EXPECT_NE(
      message_of(gltf).find("#/meshes/0/primitives/0/targets/0/POSITION: found 2 elements for 3"),
      std::string::npos)
      << message_of(gltf);
}

// There are two joints. The second is at (1, 0, 0) and is rotated by 90 degrees about Z.
class GltfSkin : public testing::Test {
 protected:
  GltfSkin() {
    const int mesh = gltf_.add_triangle();
    auto& attributes = gltf_.primitive(mesh)["attributes"];
    attributes["NORMAL"] = gltf_.add_accessor<float>("VEC3", {0, 0, 1, 1, 0, 0, 0, 1, 0});
    // Vertex 0 follows joint 0, vertex 1 follows joint 1, and vertex 2 follows both, four to one.
    // The weights of vertex 2 do not add up to 1, as after quantisation.
    attributes["JOINTS_0"] =
        gltf_.add_accessor<uint8_t>("VEC4", {0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0});
    attributes["WEIGHTS_0"] =
        gltf_.add_accessor<uint8_t>("VEC4", {255, 0, 0, 0, 255, 0, 0, 0, 200, 50, 0, 0}, true);
    const float h = float(std::sqrt(0.5));
    first_ = gltf_.push("nodes", {{"translation", {0, 0, 5}}, {"children", {2}}});
    second_ = gltf_.push("nodes", {{"translation", {1, 0, 0}}, {"rotation", {0, 0, h, h}}});
    gltf_.add_to_scene(first_);
    gltf_.push(
        "skins",
        {{"joints", {first_, second_}},
         {"inverseBindMatrices",
          gltf_.add_accessor<float>("MAT4", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0,  0, 0, 1,  //
                                             1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -1, 0, 0, 1})}});
    gltf_.root["nodes"][0]["skin"] = 0;
    // This has no effect, because the joints place a skinned mesh.
    gltf_.root["nodes"][0]["translation"] = {1000, 0, 0};
  }
  GltfBuilder gltf_;
  int first_ = 0, second_ = 0;
};

TEST_F(GltfSkin, JointsPlaceTheVertices) {
  const SceneDescription scene = load(gltf_);
  expect_close(world_position(scene, 0, 0), Vec3d(0, 0, 5));
  // (1, 0, 0) is the origin of joint 1.
  expect_close(world_position(scene, 0, 1), Vec3d(1, 0, 5));
  // Joint 0 moves (0, 1, 0) to (0, 1, 5). For joint 1 it is (-1, 1, 0), rotated to (-1, -1, 0), so
  // joint 1 moves it to (0, -1, 5).
  expect_close(world_position(scene, 0, 2), Vec3d(0, 0.8 - 0.2, 5));
  const MeshDescription& mesh = scene.meshes[0];
  expect_close(Vec3d(mesh.normals[1]), Vec3d(0, 1, 0));  // +x rotated
  const double length = std::hypot(0.2, 0.8);
  expect_close(Vec3d(mesh.normals[2]), Vec3d(-0.2 / length, 0.8 / length, 0));
  ASSERT_EQ(scene.coverage.approximated.size(), 1u);
  EXPECT_EQ(scene.coverage.approximated[0].rfind("skin", 0), 0u);
}

TEST_F(GltfSkin, FarFromTheOriginNothingIsRounded) {
  gltf_.root["nodes"][size_t(first_)]["translation"] = {1e8, 0.25, 5};
  const SceneDescription scene = load(gltf_);
  expect_close(world_position(scene, 0, 1), Vec3d(1e8 + 1, 0.25, 5), 1e-7);
}

TEST_F(GltfSkin, InverseBindMatricesDefaultToIdentity) {
  gltf_.root["skins"][0].erase("inverseBindMatrices");
  const SceneDescription scene = load(gltf_);
  expect_close(world_position(scene, 0, 1), Vec3d(1, 1, 5));
}

TEST_F(GltfSkin, BadCountsAndJointsAreErrors) {
  GltfBuilder more = gltf_;
  more.root["skins"][0]["joints"] = {first_, second_, first_};
  EXPECT_NE(message_of(more).find("#/skins/0/inverseBindMatrices: found 2 matrices for 3 joints"),
            std::string::npos);
  GltfBuilder fewer = gltf_;
  fewer.root["skins"][0]["joints"] = {first_};
  EXPECT_NE(message_of(fewer).find("attributes/JOINTS_0: vertex 1 uses a joint"), std::string::npos)
      << message_of(fewer);
  GltfBuilder none = gltf_;
  none.root["skins"][0]["joints"] = json::array();
  EXPECT_NE(message_of(none).find("#/skins/0/joints"), std::string::npos);
  GltfBuilder shape = gltf_;
  shape.root["skins"][0]["inverseBindMatrices"] = 0;
  EXPECT_NE(message_of(shape).find("MAT4"), std::string::npos);
}

}  // namespace
}  // namespace emberline
