// Tests the node hierarchy: transforms, instances, cameras, lights and the selection of the scene.
#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

#include <cmath>

#include "support/loaded_gltf.h"

namespace emberline {
namespace {

using nlohmann::json;
using test::GltfBuilder;
using test::load;
using test::message_of;

Vec3d transformed(const Mat44d& m, const Vec3d& p) {
  Vec3d out;
  m.multVecMatrix(p, out);
  return out;
}

void expect_equal(const Vec3d& a, const Vec3d& b) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], 1e-12) << a << " against " << b;
}

TEST(GltfScene, TranslationRotationScaleInThatOrder) {
  GltfBuilder gltf;
  gltf.add_triangle();
  const double h = std::sqrt(0.5);
  gltf.root["nodes"][0].update(
      {{"translation", {10, 20, 30}}, {"rotation", {0, 0, h, h}}, {"scale", {2, 3, 4}}});
  // (1, 1, 1) is scaled to (2, 3, 4), rotated by 90 degrees about Z to (-3, 2, 4), and then moved.
  expect_equal(transformed(load(gltf).instances[0].to_world, Vec3d(1.0)), Vec3d(7, 22, 34));
}

TEST(GltfScene, AMatrixIsColumnMajor) {
  GltfBuilder gltf;
  gltf.add_triangle();
  // The matrix maps X to Y and Y to -X, and then adds (5, 6, 7).
  gltf.root["nodes"][0]["matrix"] = {0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1};
  expect_equal(transformed(load(gltf).instances[0].to_world, Vec3d(1, 2, 3)), Vec3d(3, 7, 10));
}

TEST(GltfScene, ParentsApplyAfterChildrenInDoublePrecision) {
  GltfBuilder gltf;
  gltf.add_triangle();
  gltf.root["nodes"][0]["translation"] = {0.001, 0, 0};
  gltf.root["nodes"].push_back(
      {{"children", {0}}, {"scale", {2, 2, -2}}, {"translation", {1e7, 0, 0}}});
  gltf.root["scenes"][0]["nodes"] = {1};
  const Mat44d m = load(gltf).instances[0].to_world;
  EXPECT_EQ(m[3][0], 1e7 + 0.002);
  EXPECT_LT(m.determinant(), 0.0);  // the transform mirrors
}

TEST(GltfScene, AMeshUsedTwiceIsStoredOnce) {
  GltfBuilder gltf;
  const int mesh = gltf.add_triangle();
  gltf.root["meshes"][0]["name"] = "tri";
  gltf.root["meshes"][0]["primitives"].push_back(gltf.primitive());
  gltf.add_mesh_node(mesh);
  gltf.root["nodes"][1]["name"] = "second";
  const SceneDescription scene = load(gltf);
  ASSERT_EQ(scene.meshes.size(), 2u);
  EXPECT_EQ(scene.meshes[0].name, "tri/0");
  EXPECT_EQ(scene.meshes[1].name, "tri/1");
  ASSERT_EQ(scene.instances.size(), 4u);
  EXPECT_EQ(scene.instances[0].name, "node 0");
  EXPECT_EQ(scene.instances[3].name, "second");
  EXPECT_EQ(scene.instances[3].mesh, 1);
}

TEST(GltfScene, TheDefaultSceneElseTheFirstElseAllRoots) {
  GltfBuilder gltf;
  const int mesh = gltf.add_triangle();
  gltf.push("nodes", {{"mesh", mesh}, {"name", "other"}});
  gltf.push("nodes", {{"mesh", mesh}, {"name", "child"}});
  gltf.root["nodes"][1]["children"] = {2};
  gltf.root["scenes"].push_back({{"nodes", {1}}});
  const auto names = [&] {
    std::vector<std::string> result;
    for (const InstanceDescription& i : load(gltf).instances) result.push_back(i.name);
    return result;
  };
  EXPECT_EQ(names(), std::vector<std::string>{"node 0"});
  gltf.root["scene"] = 1;
  EXPECT_EQ(names(), (std::vector<std::string>{"other", "child"}));
  gltf.root.erase("scene");
  gltf.root.erase("scenes");
  EXPECT_EQ(names(), (std::vector<std::string>{"node 0", "other", "child"}));
}

TEST(GltfScene, ANodeListedTogetherWithItsDescendantIsDrawnOnce) {
  GltfBuilder gltf;
  gltf.add_triangle();
  gltf.root["nodes"].push_back({{"children", {0}}, {"translation", {1, 0, 0}}});
  gltf.root["scenes"][0]["nodes"] = {0, 1, 0};
  const SceneDescription scene = load(gltf);
  ASSERT_EQ(scene.instances.size(), 1u);
  EXPECT_EQ(scene.instances[0].to_world[3][0], 1.0);
}

TEST(GltfScene, ObjectsScaledToALineOrAPointAreDroppedAndCounted) {
  GltfBuilder gltf;
  const int mesh = gltf.add_triangle();
  const json singular[] = {
      {{"mesh", mesh}, {"scale", {0, 0, 1}}},
      {{"mesh", mesh}, {"scale", {0, 0, 0}}},
      {{"mesh", mesh}, {"matrix", {1, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1}}},
      {{"mesh", mesh}, {"scale", {1e-35, 1, 1e-38}}}};
  for (const json& node : singular) gltf.add_to_scene(gltf.push("nodes", node));
  // Tiny, huge and mirrored scales are valid.
  gltf.add_to_scene(gltf.push("nodes", {{"mesh", mesh}, {"scale", {1e-9, 1e9, -1}}}));
  const SceneDescription scene = load(gltf);
  EXPECT_EQ(scene.repairs.singular_instances, 4u);
  EXPECT_EQ(scene.instances.size(), 2u);
}

// Cameras and lamps ignore scale. If they are scaled to a line or a point, they keep their position
// and rotation.
TEST(GltfScene, CamerasAndLampsKeepTheirDirectionsWithoutAScale) {
  for (const json& scale : {json{0, 0, 0}, json{1, 0, 0}, json{0, 2, 0}}) {
    GltfBuilder gltf;
    gltf.add_triangle();
    gltf.root["extensions"]["KHR_lights_punctual"]["lights"] = {
        {{"type", "spot"}, {"spot", json::object()}}};
    gltf.root["extensionsUsed"] = {"KHR_lights_punctual"};
    gltf.root["cameras"] = {
        {{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", .1}}}}};
    const double half = std::sqrt(.5);
    // The parent makes a quarter turn about Y, and the child makes one about X.
    const int child =
        gltf.push("nodes", {{"camera", 0},
                            {"rotation", {half, 0, 0, half}},
                            {"scale", scale},
                            {"translation", {1, 0, 0}},
                            {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
    const int parent = gltf.push(
        "nodes",
        {{"rotation", {0, half, 0, half}}, {"translation", {0, 3, 0}}, {"children", {child}}});
    gltf.root["scenes"][0]["nodes"].push_back(parent);
    const SceneDescription scene = load(gltf);
    ASSERT_EQ(scene.cameras.size(), 1u) << scale;
    ASSERT_EQ(scene.lights.size(), 1u) << scale;
    for (const Mat44d& m : {scene.cameras[0].to_world, scene.lights[0].to_world}) {
      // The rotations map -Z to +Y, +Y to +Z and then to +X, and +X to -Z.
      EXPECT_NEAR(-m[2][1], 1, 1e-6) << scale;
      EXPECT_NEAR(m[1][0], 1, 1e-6) << scale;
      EXPECT_NEAR(m[3][2], -1, 1e-6) << scale;
      EXPECT_NEAR(m[3][1], 3, 1e-6) << scale;
    }
  }
}

// An object with a scale of 0 on one axis is flat to within a millionth and has the normals of the
// plane.
TEST(GltfScene, ObjectsScaledToAPlaneAreFlat) {
  GltfBuilder gltf;
  const int positions =
      gltf.add_accessor<float>("VEC3", {0, 0, 5, 1, 0, 6, 0, 1, 7, 1, 1, 5, 0, 1, 7, 1, 0, 6});
  const int normals = gltf.add_accessor<float>("VEC3", std::vector<float>(18, 0.57735f));
  const int mesh = gltf.add_mesh({{"attributes", {{"POSITION", positions}, {"NORMAL", normals}}}});
  const double h = std::sqrt(0.5);
  gltf.push("nodes", {{"mesh", mesh}});
  const json flat[] = {
      {{"mesh", mesh}, {"scale", {2, 3, 0}}},
      {{"mesh", mesh}, {"scale", {2, 3, 1e-38}}},
      {{"mesh", mesh}, {"scale", {-2, 3, 0}}, {"rotation", {h, 0, 0, h}}},
      {{"children", {0}}, {"scale", {1e6, 0, 1e6}}, {"translation", {0, 4, 0}}},
      {{"mesh", mesh}, {"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 0, 0, 0, 1}}}};
  for (const json& node : flat) gltf.add_to_scene(gltf.push("nodes", node));
  const SceneDescription scene = load(gltf);
  EXPECT_EQ(scene.repairs.singular_instances, 0u);
  ASSERT_EQ(scene.instances.size(), 5u);
  ASSERT_EQ(scene.meshes.size(), 1u);
  EXPECT_TRUE(scene.meshes[0].normals.empty());
  const Vec3d planes[] = {{0, 0, 1}, {0, 0, 1}, {0, 1, 0}, {0, 1, 0}, {0, 0, 1}};
  for (size_t i = 0; i < 5; ++i) {
    const Mat44d& m = scene.instances[i].to_world;
    EXPECT_GT(m.determinant(), 0);
    WorldBounds bounds;
    for (const Vec3f& p : scene.meshes[0].positions) bounds.extendBy(transformed(m, to_double(p)));
    EXPECT_LT(dot(bounds.max - bounds.min, planes[i]), 4e-5 * bounds.radius()) << i;
    EXPECT_GT(dot(bounds.max - bounds.min, planes[i]), 0) << i;
    EXPECT_NEAR(dot(bounds.center(), planes[i]), i == 3 ? 4 : 0, 4e-6) << i;
  }
  // Adds the unscaled mesh, with two instances.
  gltf.add_mesh_node(mesh);
  gltf.root["nodes"].back()["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
      {"SCALE", gltf.add_accessor<float>("VEC3", {1, 1, 1, 1, 0, 1, 0, 0, 1})}};
  const SceneDescription both = load(gltf);
  EXPECT_EQ(both.repairs.singular_instances, 1u);
  ASSERT_EQ(both.instances.size(), 7u);
  ASSERT_EQ(both.meshes.size(), 2u);
  EXPECT_EQ(both.meshes[size_t(both.instances[5].mesh)].normals.size(), 6u);
  EXPECT_TRUE(both.meshes[size_t(both.instances[6].mesh)].normals.empty());
}

TEST(GltfScene, CamerasAndLightsBelowAFlatNodeKeepTheirDirections) {
  GltfBuilder gltf;
  gltf.add_triangle();
  gltf.push("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 1}}}});
  gltf.root["extensions"]["KHR_lights_punctual"]["lights"][0] = {
      {"type", "spot"}, {"spot", {{"outerConeAngle", 0.5}}}};
  const double h = std::sqrt(0.5);
  const json turned = {{"camera", 0},
                       {"rotation", {0, h, 0, h}},
                       {"translation", {1, 2, 3}},
                       {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}};
  for (const json& scale : {json{0, 1, 1}, json{1, 0, 1}, json{1, 1, 0}}) {
    const int child = gltf.push("nodes", turned);
    gltf.add_to_scene(gltf.push("nodes", {{"children", {child}}, {"scale", scale}}));
  }
  const SceneDescription scene = load(gltf);
  ASSERT_EQ(scene.cameras.size(), 3u);
  ASSERT_EQ(scene.lights.size(), 3u);
  for (size_t i = 0; i < 3; ++i) {
    for (const Mat44d& m : {scene.cameras[i].to_world, scene.lights[i].to_world}) {
      const Vec3d back(m[2][0], m[2][1], m[2][2]), up(m[1][0], m[1][1], m[1][2]);
      EXPECT_NEAR(dot(back.normalized(), Vec3d(1, 0, 0)), 1, 1e-12) << i;
      EXPECT_NEAR(dot(up.normalized(), Vec3d(0, 1, 0)), 1, 1e-12) << i;
      EXPECT_NEAR(m[3][0], i == 0 ? 0 : 1, 1e-12) << i;
    }
  }
}

TEST(GltfScene, TransformsBeyondAllMeasureAreErrors) {
  GltfBuilder gltf;
  gltf.add_triangle();
  gltf.root["nodes"][0]["scale"] = {1e12, 1, 1};
  gltf.root["nodes"].push_back({{"children", {0}}, {"scale", {1e12, 1, 1}}});
  gltf.root["scenes"][0]["nodes"] = {1};
  EXPECT_NE(message_of(gltf).find("#/nodes/0: "), std::string::npos) << message_of(gltf);
  gltf.root["nodes"][1]["scale"] = {1e39, 1, 1};
  EXPECT_NE(message_of(gltf).find("#/nodes/1/scale/0: "), std::string::npos) << message_of(gltf);
}

TEST(GltfScene, GpuInstances) {
  GltfBuilder gltf;
  gltf.add_triangle();
  const double h = std::sqrt(0.5);
  const int t = gltf.add_accessor<float>("VEC3", {1, 0, 0, 0, 2, 0});
  const int r = gltf.add_accessor<float>("VEC4", {0, 0, 0, 1, 0, 0, float(h), float(h)});
  const int s = gltf.add_accessor<float>("VEC3", {1, 1, 1, 2, 2, 2});
  gltf.root["nodes"][0]["translation"] = {100, 0, 0};
  gltf.root["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
      {"TRANSLATION", t}, {"ROTATION", r}, {"SCALE", s}};
  gltf.root["extensionsUsed"] = {"EXT_mesh_gpu_instancing"};
  const SceneDescription scene = load(gltf);
  EXPECT_EQ(scene.meshes.size(), 1u);
  ASSERT_EQ(scene.instances.size(), 2u);
  expect_equal(transformed(scene.instances[0].to_world, Vec3d(1, 0, 0)), Vec3d(102, 0, 0));
  const Vec3d p = transformed(scene.instances[1].to_world, Vec3d(1, 0, 0));
  EXPECT_NEAR(p.x, 100, 1e-6);
  EXPECT_NEAR(p.y, 4, 1e-6);
  // Rotations may also be normalised integers.
  auto& attributes = gltf.root["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
  attributes["ROTATION"] = gltf.add_accessor<int8_t>("VEC4", {0, 0, 0, 127, 0, 0, 90, 90}, true);
  EXPECT_NEAR(transformed(load(gltf).instances[1].to_world, Vec3d(1, 0, 0)).y, 4, 1e-6);
  attributes["SCALE"] = gltf.add_accessor<float>("VEC3", {1, 1, 1});
  EXPECT_NE(message_of(gltf).find("EXT_mesh_gpu_instancing"), std::string::npos);
}

TEST(GltfScene, Cameras) {
  GltfBuilder gltf;
  gltf.add_triangle();
  gltf.push("cameras", {{"type", "perspective"},
                        {"name", "main"},
                        {"perspective", {{"yfov", 0.6}, {"znear", 0.1}, {"aspectRatio", 1.5}}}});
  gltf.push("cameras", {{"type", "orthographic"},
                        {"orthographic", {{"xmag", 2}, {"ymag", 3}, {"znear", 0}, {"zfar", 10}}}});
  gltf.add_to_scene(gltf.push("nodes", {{"camera", 0}, {"translation", {1, 2, 3}}}));
  gltf.add_to_scene(gltf.push("nodes", {{"camera", 1}, {"name", "plan"}}));
  gltf.add_to_scene(gltf.push(
      "nodes", {{"camera", 0}, {"matrix", {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1}}}));
  gltf.push("nodes", {{"camera", 0}});  // in no scene
  SceneDescription scene = load(gltf);
  ASSERT_EQ(scene.cameras.size(), 2u);
  EXPECT_EQ(scene.repairs.singular_instances, 1u);
  EXPECT_EQ(scene.cameras[0].name, "main");
  EXPECT_FALSE(scene.cameras[0].orthographic);
  EXPECT_DOUBLE_EQ(scene.cameras[0].fov_y, 0.6);
  EXPECT_DOUBLE_EQ(scene.cameras[0].aspect.value(), 1.5);
  EXPECT_EQ(scene.cameras[0].to_world[3][1], 2.0);
  EXPECT_EQ(scene.cameras[1].name, "plan");
  EXPECT_TRUE(scene.cameras[1].orthographic);
  EXPECT_DOUBLE_EQ(scene.cameras[1].y_mag, 3.0);

  gltf.root["cameras"][0]["perspective"].erase("aspectRatio");
  EXPECT_FALSE(load(gltf).cameras[0].aspect.has_value());
  gltf.root["cameras"][0]["perspective"]["yfov"] = 4;
  const auto fault = [&] {
    const SceneDescription broken = load(gltf);
    EXPECT_FALSE(broken.cameras.at(1).fault);
    return std::string(broken.cameras.at(0).fault ? broken.cameras[0].fault->what() : "none");
  };
  EXPECT_NE(fault().find("#/cameras/0/perspective/yfov"), std::string::npos) << fault();
  gltf.root["cameras"][0] = {{"type", "fisheye"}};
  EXPECT_NE(fault().find("#/cameras/0/type"), std::string::npos) << fault();
}

TEST(GltfScene, PunctualLights) {
  GltfBuilder gltf;
  gltf.add_triangle();
  gltf.root["extensionsUsed"] = {"KHR_lights_punctual"};
  gltf.root["extensions"]["KHR_lights_punctual"]["lights"] = {
      {{"type", "point"},
       {"color", {1, 0.5, 0}},
       {"intensity", 20},
       {"name", "bulb"},
       {"range", 3}},
      {{"type", "directional"}, {"range", 3}},
      {{"type", "spot"}, {"spot", {{"innerConeAngle", 0.2}, {"outerConeAngle", 0.5}}}},
      {{"type", "spot"}, {"spot", {{"innerConeAngle", 1.5707964}, {"outerConeAngle", 1.5707964}}}}};
  for (int light = 0; light < 4; ++light) {
    gltf.add_to_scene(
        gltf.push("nodes", {{"translation", {light, 0, 0}},
                            {"extensions", {{"KHR_lights_punctual", {{"light", light}}}}}}));
  }
  const SceneDescription scene = load(gltf);
  ASSERT_EQ(scene.lights.size(), 4u);
  EXPECT_EQ(scene.lights[0].name, "bulb");
  EXPECT_EQ(scene.lights[0].type, PunctualType::kPoint);
  EXPECT_EQ(scene.lights[0].intensity, Rgb(20, 10, 0));
  EXPECT_EQ(scene.lights[0].range, 3.0f);
  EXPECT_EQ(scene.lights[1].range, std::numeric_limits<float>::infinity());
  EXPECT_EQ(scene.lights[2].range, std::numeric_limits<float>::infinity());
  EXPECT_TRUE(scene.coverage.ignored.empty());
  EXPECT_EQ(scene.lights[1].type, PunctualType::kDirectional);
  EXPECT_EQ(scene.lights[1].intensity, Rgb(1.0f));
  EXPECT_EQ(scene.lights[1].to_world[3][0], 1.0);
  EXPECT_EQ(scene.lights[2].type, PunctualType::kSpot);
  EXPECT_FLOAT_EQ(scene.lights[2].inner_cone, 0.2f);
  EXPECT_FLOAT_EQ(scene.lights[2].outer_cone, 0.5f);
  EXPECT_LE(scene.lights[3].outer_cone, 1.5707964f);
  EXPECT_LT(scene.lights[3].inner_cone, scene.lights[3].outer_cone);
  gltf.root["extensions"]["KHR_lights_punctual"]["lights"][0]["type"] = "area";
  EXPECT_EQ(load(gltf).lights.size(), 3u);  // with a warning (failure/needless_faults_test)
  gltf.root["extensionsRequired"] = {"KHR_lights_punctual"};
  EXPECT_NE(message_of(gltf).find("#/extensions/KHR_lights_punctual/lights/0/type"),
            std::string::npos);
}

}  // namespace
}  // namespace emberline
