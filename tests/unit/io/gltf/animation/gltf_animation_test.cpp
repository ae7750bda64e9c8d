// Tests what the animations of a file move, and where it is at a given time. The expected values
// are computed from the specification's formulas, which use column vectors.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "support/animated_gltf.h"
#include "support/loaded_gltf.h"
#include "support/scene_validation.h"

namespace emberline {
namespace {

using nlohmann::json;
using test::AnimationBuilder;
using test::GltfBuilder;
using test::load;
using test::load_at;

// The rows of a matrix that multiplies column vectors.
using Affine = std::array<std::array<double, 4>, 3>;

Affine product(const Affine& a, const Affine& b) {
  Affine c{};
  for (size_t i = 0; i < 3; ++i) {
    for (size_t j = 0; j < 4; ++j) {
      for (size_t k = 0; k < 3; ++k) c[i][j] += a[i][k] * b[k][j];
    }
    c[i][3] += a[i][3];
  }
  return c;
}

Affine placed(double x, double y, double z) { return {{{1, 0, 0, x}, {0, 1, 0, y}, {0, 0, 1, z}}}; }
Affine scaled(double s) { return {{{s, 0, 0, 0}, {0, s, 0, 0}, {0, 0, s, 0}}}; }
Affine about_z(double a) {
  return {{{std::cos(a), -std::sin(a), 0, 0}, {std::sin(a), std::cos(a), 0, 0}, {0, 0, 1, 0}}};
}

Vec3d image(const Affine& m, const Vec3d& p) {
  Vec3d out;
  for (size_t i = 0; i < 3; ++i) {
    out[int(i)] = m[i][0] * p.x + m[i][1] * p.y + m[i][2] * p.z + m[i][3];
  }
  return out;
}

Vec3d vertex(const SceneDescription& scene, size_t instance, size_t index) {
  const InstanceDescription& i = scene.instances.at(instance);
  Vec3d out;
  i.to_world.multVecMatrix(Vec3d(scene.meshes[size_t(i.mesh)].positions.at(index)), out);
  return out;
}

void expect_at(const Vec3d& found, const Vec3d& expected, double tolerance = 1e-6) {
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(found[c], expected[c], tolerance) << found << " against " << expected;
  }
}

// Returns the log messages while `body` runs.
template <class Body>
std::vector<std::string> warnings_of(const Body& body) {
  std::vector<std::string> lines;
  set_log_sink([&](LogKind, std::string_view message) { lines.emplace_back(message); });
  body();
  set_log_sink(nullptr);
  return lines;
}

size_t count_with(const std::vector<std::string>& lines, const std::string& part) {
  return size_t(std::ranges::count_if(
      lines, [&](const std::string& line) { return line.find(part) != std::string::npos; }));
}

constexpr Vec3d kCorners[] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
const float kHalf = float(std::sqrt(0.5));

// The file has a triangle in node 0, which is a child of node 1.
class GltfAnimationTest : public testing::Test {
 protected:
  GltfAnimationTest() {
    mesh_ = gltf_.add_triangle();
    gltf_.root["scenes"][0]["nodes"] = {1};
    gltf_.push("nodes", {{"children", {0}}, {"translation", {7, 7, 7}}});
  }
  json& node(size_t i) { return gltf_.root["nodes"][i]; }

  GltfBuilder gltf_;
  int mesh_ = 0;
};

TEST_F(GltfAnimationTest, NodesMoveTurnAndScale) {
  node(0)["translation"] = {1, 0, 0};
  AnimationBuilder(gltf_)
      .move(1, "rotation", {1, 3}, "VEC4", {0, 0, 0, 1, 0, 0, kHalf, kHalf})
      .move(0, "scale", {0, 2}, "VEC3", {1, 1, 1, 3, 3, 3})
      .move(1, "translation", {0, 4}, "VEC3", {0, 0, 0, 8, 4, 0}, "STEP");
  for (const double time : {0.0, 1.0, 1.7, 2.0, 3.0, 4.0, 9.0}) {
    const SceneDescription scene = load_at(gltf_, time);
    const double angle = 3.14159265358979 / 2 * std::clamp((time - 1) / 2, 0.0, 1.0);
    const Affine parent = product(time < 4 ? placed(0, 0, 0) : placed(8, 4, 0), about_z(angle));
    const Affine world = product(parent, product(placed(1, 0, 0), scaled(1 + std::min(time, 2.0))));
    for (size_t v = 0; v < 3; ++v) expect_at(vertex(scene, 0, v), image(world, kCorners[v]));
    EXPECT_EQ(test::find_scene_violation(scene), "");
    EXPECT_TRUE(scene.coverage.ignored.empty());
  }
}

TEST_F(GltfAnimationTest, WithoutATimeTheSceneIsAtRest) {
  const SceneDescription before = load(gltf_);
  AnimationBuilder(gltf_).move(1, "translation", {0, 1}, "VEC3", {5, 5, 5, 6, 6, 6});
  const SceneDescription scene = load(gltf_);
  EXPECT_EQ(scene.instances[0].to_world, before.instances[0].to_world);
  EXPECT_TRUE(scene.coverage.ignored.empty());
  EXPECT_EQ(scene.coverage.not_played, "1 animation; set `time` or `frame` to play it");
  // An animation without a time is evaluated at its start.
  const test::TempFolder folder;
  const std::string path = gltf_.write_glb(folder / "a.glb");
  expect_at(vertex(load_gltf(path, {.animation = "0"}), 0, 0), Vec3d(5, 5, 5));
}

TEST_F(GltfAnimationTest, IsChosenByNameOrIndexOrAll) {
  AnimationBuilder(gltf_, "up").move(1, "translation", {0}, "VEC3", {0, 1, 0});
  AnimationBuilder(gltf_, "big").move(1, "scale", {0, 2}, "VEC3", {4, 4, 4, 6, 6, 6});
  AnimationBuilder(gltf_, "up").move(1, "translation", {0}, "VEC3", {0, 2, 0});
  const auto corner = [&](const std::string& animation) {
    return vertex(load_at(gltf_, 0, animation), 0, 1);
  };
  expect_at(corner(""), Vec3d(1, 1, 0));
  expect_at(corner("up"), Vec3d(1, 1, 0));
  expect_at(corner("2"), Vec3d(1, 2, 0));
  expect_at(corner("big"), Vec3d(11, 7, 7));
  expect_at(corner("all"), Vec3d(4, 2, 0));  // the later of two that move the same property
  EXPECT_EQ(count_with(warnings_of([&] { corner(""); }), "the first animation is used"), 1u);
  for (const char* wrong : {"down", "3", "-1", "All"}) {
    try {
      corner(wrong);
      ADD_FAILURE() << wrong;
    } catch (const UsageError& error) {
      EXPECT_NE(std::string(error.what()).find("the file has 0 'up', 1 'big', 2 'up'"),
                std::string::npos);
    }
  }
  const std::vector<AnimationDescription> list = load(gltf_).animations;
  ASSERT_EQ(list.size(), 3u);
  EXPECT_EQ(list[1].name, "big");
  EXPECT_EQ(list[1].duration, 2.0);
  EXPECT_EQ(list[1].nodes, 1u);
}

TEST_F(GltfAnimationTest, AFileWithoutAnimationsStaysAtRest) {
  EXPECT_EQ(count_with(warnings_of([&] { load_at(gltf_, 1); }), "the file has no animation"), 1u);
  EXPECT_THROW(load_at(gltf_, 1, "all"), UsageError);
}

TEST_F(GltfAnimationTest, TimeOutsideTheAnimationIsReportedOnce) {
  AnimationBuilder(gltf_).move(1, "translation", {1, 2}, "VEC3", {1, 0, 0, 2, 0, 0});
  const auto lines = [&](double time) {
    return count_with(warnings_of([&] { load_at(gltf_, time); }), "is outside the animation");
  };
  EXPECT_EQ(lines(-0.1), 1u);
  EXPECT_EQ(lines(0), 0u);
  EXPECT_EQ(lines(2), 0u);
  EXPECT_EQ(lines(2.1), 1u);
  expect_at(vertex(load_at(gltf_, -3), 0, 0), Vec3d(1, 0, 0));
  expect_at(vertex(load_at(gltf_, 3), 0, 0), Vec3d(2, 0, 0));
}

TEST_F(GltfAnimationTest, NormalizedIntegersAreTheTables) {
  AnimationBuilder(gltf_).move<int16_t>(1, "rotation", {0}, "VEC4", {0, 0, 23170, 23170});
  expect_at(vertex(load_at(gltf_, 0), 0, 1), Vec3d(7, 8, 7), 1e-4);
  gltf_.primitive(mesh_)["targets"] = {
      {{"POSITION", gltf_.add_accessor<float>("VEC3", {0, 0, 1, 0, 0, 1, 0, 0, 1})}}};
  AnimationBuilder(gltf_, "bytes").move<int8_t>(0, "weights", {0, 1}, "SCALAR", {-128, 64});
  expect_at(vertex(load_at(gltf_, 0, "bytes"), 0, 0), Vec3d(7, 7, 6));
  expect_at(vertex(load_at(gltf_, 1, "bytes"), 0, 0), Vec3d(7, 7, 7 + 64.0 / 127));
}

TEST_F(GltfAnimationTest, MorphWeightsAreTheMeshsAtItsTime) {
  gltf_.primitive(mesh_)["targets"] = {
      {{"POSITION", gltf_.add_accessor<float>("VEC3", {0, 0, 1, 0, 0, 2, 0, 0, 3})}},
      {{"POSITION", gltf_.add_accessor<float>("VEC3", {1, 0, 0, 0, 0, 0, 0, -1, 0})}}};
  gltf_.root["meshes"][0]["weights"] = {0.25, 0.5};
  node(1).erase("translation");
  // A second node with the same mesh is unaffected.
  gltf_.add_mesh_node(mesh_);
  // Each key has the in-tangents, the values and the out-tangents of two targets.
  AnimationBuilder(gltf_).move(0, "weights", {0, 2}, "SCALAR",
                               {0, 0, 0.5f, 1, 1, -1, 0.5f, 0, 2, 0, 0, 0}, "CUBICSPLINE");
  for (const double time : {0.0, 0.5, 1.5, 2.0}) {
    const double t = time / 2, t2 = t * t, t3 = t2 * t;
    const auto spline = [&](double v0, double b0, double a1, double v1) {
      return (2 * t3 - 3 * t2 + 1) * v0 + 2 * (t3 - 2 * t2 + t) * b0 + (3 * t2 - 2 * t3) * v1 +
             2 * (t3 - t2) * a1;
    };
    const double first = spline(0.5, 1, 0.5, 2), second = spline(1, -1, 0, 0);
    const SceneDescription scene = load_at(gltf_, time);
    expect_at(vertex(scene, 0, 0), Vec3d(second, 0, first));
    expect_at(vertex(scene, 0, 2), Vec3d(0, 1 - second, 3 * first));
    expect_at(vertex(scene, 1, 2), Vec3d(0, 0.5, 0.75));
    EXPECT_TRUE(scene.coverage.approximated.empty());
  }
}

// There are two joints, one below the other, and both rotate.
TEST_F(GltfAnimationTest, JointsCarryTheirVertices) {
  auto& attributes = gltf_.primitive(mesh_)["attributes"];
  attributes["NORMAL"] = gltf_.add_accessor<float>("VEC3", {0, 0, 1, 1, 0, 0, 0, 1, 0});
  attributes["JOINTS_0"] =
      gltf_.add_accessor<uint8_t>("VEC4", {0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0});
  attributes["WEIGHTS_0"] =
      gltf_.add_accessor<float>("VEC4", {1, 0, 0, 0, 1, 0, 0, 0, 0.25f, 0.75f, 0, 0});
  const int lower = gltf_.push("nodes", {{"children", {3}}, {"translation", {0, 0, 5}}});
  const int upper = gltf_.push("nodes", {{"translation", {1, 0, 0}}});
  gltf_.add_to_scene(lower);
  const std::vector<float> inverse = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0,  0, 0, 1,  //
                                      1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -1, 0, 0, 1};
  gltf_.push("skins", {{"joints", {lower, upper}},
                       {"inverseBindMatrices", gltf_.add_accessor<float>("MAT4", inverse)}});
  node(0)["skin"] = 0;
  AnimationBuilder(gltf_)
      .move(lower, "rotation", {0, 1}, "VEC4", {0, 0, 0, 1, 0, 0, 1, 0})
      .move(upper, "rotation", {0, 2}, "VEC4", {0, 0, 0, 1, 0, 0, kHalf, kHalf})
      .move(upper, "scale", {0, 1}, "VEC3", {1, 1, 1, 2, 2, 2});
  constexpr double kPi = 3.14159265358979;
  for (const double time : {0.0, 0.3, 1.0, 1.6}) {
    const double turned = kPi * std::min(time, 1.0), bent = kPi / 4 * time;
    const Affine first = product(placed(0, 0, 5), about_z(turned));
    const Affine second = product(product(product(first, placed(1, 0, 0)), about_z(bent)),
                                  product(scaled(1 + std::min(time, 1.0)), placed(-1, 0, 0)));
    const SceneDescription scene = load_at(gltf_, time);
    expect_at(vertex(scene, 0, 0), image(first, kCorners[0]));
    expect_at(vertex(scene, 0, 1), image(second, kCorners[1]));
    expect_at(vertex(scene, 0, 2),
              image(first, kCorners[2]) * 0.25 + image(second, kCorners[2]) * 0.75);
    const Vec3f normal = scene.meshes[0].normals[1];
    expect_at(Vec3d(normal), Vec3d(std::cos(turned + bent), std::sin(turned + bent), 0));
    EXPECT_TRUE(scene.coverage.approximated.empty());
  }
}

TEST_F(GltfAnimationTest, ASingularJointMakesNoNaN) {
  auto& attributes = gltf_.primitive(mesh_)["attributes"];
  attributes["NORMAL"] = gltf_.add_accessor<float>("VEC3", {0, 0, 1, 0, 0, 1, 0, 0, 1});
  attributes["JOINTS_0"] =
      gltf_.add_accessor<uint8_t>("VEC4", {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0});
  attributes["WEIGHTS_0"] =
      gltf_.add_accessor<uint8_t>("VEC4", {255, 0, 0, 0, 255, 0, 0, 0, 255, 0, 0, 0}, true);
  gltf_.push("skins", {{"joints", {gltf_.push("nodes", json::object())}}});
  node(0)["skin"] = 0;
  gltf_.add_mesh_node(gltf_.add_mesh({{"attributes", {{"POSITION", 0}}}, {"indices", 1}}));
  AnimationBuilder(gltf_).move(2, "scale", {0, 1, 2}, "VEC3", {0, 1, 1, 0, 0, 1, 0, 0, 0});
  for (const double time : {0.0, 0.5, 1.0, 2.0}) {
    EXPECT_EQ(test::find_scene_violation(load_at(gltf_, time)), "") << time;
  }
}

TEST_F(GltfAnimationTest, CamerasAndLightsMoveWithTheirNodes) {
  gltf_.root["cameras"] = {
      {{"type", "perspective"}, {"perspective", {{"yfov", 0.5}, {"znear", 0.1}}}}};
  gltf_.root["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}}};
  node(1)["camera"] = 0;
  node(1)["extensions"]["KHR_lights_punctual"]["light"] = 0;
  AnimationBuilder(gltf_).move(1, "translation", {0, 2}, "VEC3", {0, 0, 0, 4, 0, 2});
  const SceneDescription scene = load_at(gltf_, 1);
  for (const Mat44d& m : {scene.cameras.at(0).to_world, scene.lights.at(0).to_world}) {
    expect_at(Vec3d(m[3][0], m[3][1], m[3][2]), Vec3d(2, 0, 1));
  }
}

// ---- KHR_animation_pointer, KHR_node_visibility

TEST_F(GltfAnimationTest, PointersReachMaterialsLightsAndCameras) {
  gltf_.root["cameras"] = {
      {{"type", "perspective"}, {"perspective", {{"yfov", 0.5}, {"znear", 0.1}}}}};
  gltf_.root["extensions"]["KHR_lights_punctual"]["lights"] = {
      {{"type", "spot"}, {"spot", json::object()}}};
  node(1)["camera"] = 0;
  node(1)["extensions"]["KHR_lights_punctual"]["light"] = 0;
  gltf_.push("materials", {{"pbrMetallicRoughness", json::object()},
                           {"emissiveFactor", {0, 0, 0}},
                           {"extensions",
                            {{"KHR_materials_ior", json::object()},
                             {"KHR_materials_emissive_strength", {{"emissiveStrength", 1}}}}}});
  gltf_.primitive()["material"] = 0;
  const std::string lamp = "/extensions/KHR_lights_punctual/lights/0/";
  AnimationBuilder(gltf_)
      .point("/materials/0/pbrMetallicRoughness/baseColorFactor", {0, 1}, "VEC4",
             {1, 0, 0, 1, 0, 0, 1, 1})
      .point("/materials/0/pbrMetallicRoughness/roughnessFactor", {0, 1}, "SCALAR", {0, 1})
      .point("/materials/0/emissiveFactor", {0, 1}, "VEC3", {0, 0, 0, 1, 1, 1})
      .point("/materials/0/extensions/KHR_materials_ior/ior", {0, 1}, "SCALAR", {1.2f, 1.6f})
      .point("/materials/0/extensions/KHR_materials_emissive_strength/emissiveStrength", {0, 1},
             "SCALAR", {0, 8})
      .point("/cameras/0/perspective/yfov", {0, 1}, "SCALAR", {0.4f, 0.8f})
      .point(lamp + "intensity", {0, 1}, "SCALAR", {0, 100})
      .point(lamp + "color", {0, 1}, "VEC3", {1, 1, 1, 0, 1, 1})
      .point(lamp + "spot/outerConeAngle", {0, 1}, "SCALAR", {0.2f, 0.6f});
  std::vector<std::string> lines;
  SceneDescription scene;
  lines = warnings_of([&] { scene = load_at(gltf_, 0.25); });
  EXPECT_TRUE(lines.empty()) << lines.front();
  const MaterialDescription& material = scene.materials[0];
  EXPECT_EQ(material.base_color, Rgb(0.75f, 0, 0.25f));
  EXPECT_FLOAT_EQ(material.roughness, 0.25f);
  EXPECT_FLOAT_EQ(material.ior, 1.3f);
  EXPECT_FLOAT_EQ(material.emission.x, 0.25f * 2.0f);
  EXPECT_NEAR(scene.cameras[0].fov_y, 0.5, 1e-7);
  EXPECT_EQ(scene.lights[0].intensity, Rgb(0.75f * 25, 25, 25));
  EXPECT_NEAR(scene.lights[0].outer_cone, 0.3, 1e-7);
  EXPECT_EQ(scene.animations[0].pointers, 9u);
}

TEST_F(GltfAnimationTest, PointersReachNodes) {
  gltf_.primitive(mesh_)["targets"] = {
      {{"POSITION", gltf_.add_accessor<float>("VEC3", {0, 0, 1, 0, 0, 1, 0, 0, 1})}},
      {{"POSITION", gltf_.add_accessor<float>("VEC3", {0, 1, 0, 0, 1, 0, 0, 1, 0})}}};
  gltf_.root["meshes"][0]["weights"] = {3, 4};
  AnimationBuilder(gltf_)
      .point("/nodes/1/translation", {0, 1}, "VEC3", {0, 0, 0, 2, 0, 0})
      .point("/nodes/1/rotation", {0}, "VEC4", {0, 0, 0, 1})
      .point("/nodes/1/scale", {0}, "VEC3", {1, 1, 2})
      .point("/nodes/0/weights/1", {0, 1}, "SCALAR", {0, 1});
  expect_at(vertex(load_at(gltf_, 0.5), 0, 0), Vec3d(1, 0.5, 6));
}

// The specification does not allow rotations on a node with a matrix, so only its translation is
// animated.
TEST_F(GltfAnimationTest, TranslationOfAMatrixNodeMoves) {
  node(1).erase("translation");
  node(1)["matrix"] = {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 1, 1, 1, 1};
  AnimationBuilder(gltf_)
      .point("/nodes/1/translation", {0}, "VEC3", {5, 6, 7})
      .point("/nodes/1/rotation", {0}, "VEC4", {0, 0, 1, 0});
  expect_at(vertex(load_at(gltf_, 0), 0, 1), Vec3d(7, 6, 7));
  AnimationBuilder(gltf_, "turn").move(1, "rotation", {0}, "VEC4", {0, 0, 1, 0});
  EXPECT_THROW(load_at(gltf_, 0, "turn"), InputError);
}

TEST_F(GltfAnimationTest, UnknownPointersAreReportedAndCounted) {
  gltf_.push("materials", json::object());
  AnimationBuilder animation(gltf_);
  animation.move(1, "translation", {0}, "VEC3", {1, 2, 3});
  const std::vector<std::string> nowhere = {
      "/materials/0/pbrMetallicRoughness/metallicFactor",  // its parent object is missing
      "/materials/1/alphaCutoff",
      "/materials/0/doubleSided",
      "/materials/00/alphaCutoff",
      "/materials/0/alphaCut",
      "/materials",
      "",
      "materials/0/alphaCutoff",
      "/nodes/0/weights",
      "/nodes/2/scale",
      "/nodes/01/scale",
      "/nodes/1/matrix",
      "/nodes/1",
      "/nodes/1/extensions/KHR_node_visibility/visible",
      "/meshes/0/weights",
      "/scene",
      "/nodes/1/weights/0",
      "/extensions/KHR_lights_punctual/lights/0/intensity"};
  for (const std::string& pointer : nowhere) animation.point(pointer, {0}, "SCALAR", {1});
  SceneDescription scene;
  const auto lines = warnings_of([&] { scene = load_at(gltf_, 0); });
  expect_at(vertex(scene, 0, 0), Vec3d(1, 2, 3));
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_NE(lines[0].find("#/animations/0/channels/1/target/extensions/KHR_animation_pointer/"
                          "pointer: \"/materials/0/pbrMetallicRoughness/metallicFactor\" does "
                          "not exist; it is left out (and 17 more like it)"),
            std::string::npos)
      << lines[0];
  EXPECT_EQ(scene.animations[0].without_effect, nowhere.size());
}

TEST_F(GltfAnimationTest, ChannelsWithoutANodeAreLeftOut) {
  AnimationBuilder animation(gltf_);
  animation.move(1, "translation", {0}, "VEC3", {1, 2, 3}).move(1, "scale", {0}, "VEC3", {9, 9, 9});
  animation.channel(1)["target"].erase("node");
  expect_at(vertex(load_at(gltf_, 0), 0, 1), Vec3d(2, 2, 3));
}

TEST_F(GltfAnimationTest, InvisibleNodesHideTheirChildren) {
  gltf_.root["cameras"] = {
      {{"type", "perspective"}, {"perspective", {{"yfov", 0.5}, {"znear", 0.1}}}}};
  gltf_.root["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}}};
  node(0)["camera"] = 0;
  node(0)["extensions"]["KHR_lights_punctual"]["light"] = 0;
  gltf_.add_mesh_node(mesh_);
  const auto counts = [&](const SceneDescription& scene) {
    return std::array{scene.instances.size(), scene.lights.size(), scene.cameras.size()};
  };
  const std::array<size_t, 3> all = {2, 1, 1}, hidden = {1, 0, 1};
  json& visible = node(1)["extensions"]["KHR_node_visibility"];
  visible = json::object();
  EXPECT_EQ(counts(load(gltf_)), all);
  visible["visible"] = false;
  EXPECT_EQ(counts(load(gltf_)), hidden);
  node(0)["extensions"]["KHR_node_visibility"]["visible"] = true;
  EXPECT_EQ(counts(load(gltf_)), hidden);

  AnimationBuilder(gltf_).point<uint8_t>("/nodes/1/extensions/KHR_node_visibility/visible",
                                         {0, 1, 2}, "BOOL", {0, 7, 0}, "STEP");
  EXPECT_EQ(counts(load_at(gltf_, 0.9)), hidden);
  EXPECT_EQ(counts(load_at(gltf_, 1.0)), all);
  EXPECT_EQ(counts(load_at(gltf_, 1.9)), all);
  EXPECT_EQ(counts(load_at(gltf_, 2.0)), hidden);
  // If everything is invisible, only the environment is left.
  node(2)["extensions"]["KHR_node_visibility"]["visible"] = false;
  EXPECT_EQ(count_with(warnings_of([&] { EXPECT_TRUE(load(gltf_).instances.empty()); }),
                       "nothing is visible (2 invisible nodes)"),
            1u);
}

}  // namespace
}  // namespace emberline
