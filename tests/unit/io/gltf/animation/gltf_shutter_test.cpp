// Tests motion while the shutter is open. At any time, everything must be where a still of that
// time has it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "renderer/core/errors.h"
#include "renderer/description/transform_parts.h"
#include "support/animated_gltf.h"
#include "support/loaded_gltf.h"
#include "support/scene_validation.h"

namespace emberline {
namespace {

using nlohmann::json;
using test::AnimationBuilder;
using test::GltfBuilder;
using test::load_at;
using test::load_open;

constexpr double kPi = 3.14159265358979;

// A step of the motion and a share of it, as defined in scene_description.h.
struct Segment {
  size_t step;
  double share;
  Segment(double share_of_all, size_t next_frame)
      : step(std::min(size_t(share_of_all * double(next_frame)), next_frame - 1)),
        share(share_of_all * double(next_frame) - double(step)) {}
};

Mat44d transform_at(const Mat44d& first, const std::vector<Mat44d>& next_frame, double share) {
  if (next_frame.empty()) return first;
  const Segment at(share, next_frame.size());
  const TransformParts before(at.step == 0 ? first : next_frame[at.step - 1]),
      after(next_frame[at.step]);
  return interpolate(before, after, at.share).matrix();
}

Vec3d vertex_at(const SceneDescription& scene, size_t instance, size_t index, double share) {
  const InstanceDescription& i = scene.instances.at(instance);
  const MeshDescription& mesh = scene.meshes[size_t(i.mesh)];
  Vec3d p(mesh.positions.at(index));
  if (!mesh.motion.empty()) {
    const Segment at(share, mesh.motion.size());
    const auto& before = at.step == 0 ? mesh.positions : mesh.motion[at.step - 1].positions;
    const Vec3d a(before[index]), b(mesh.motion[at.step].positions[index]);
    p = a + (b - a) * at.share;
  }
  Vec3d world;
  transform_at(i.to_world, i.motion, share).multVecMatrix(p, world);
  return world;
}

// The file has a triangle in node 0, which is a child of node 1.
class GltfShutterTest : public testing::Test {
 protected:
  GltfShutterTest() {
    mesh_ = gltf_.add_triangle();
    json& positions =
        gltf_.root["accessors"][gltf_.primitive(mesh_)["attributes"]["POSITION"].get<size_t>()];
    positions["min"] = {0, 0, 0};
    positions["max"] = {1, 1, 0};
    gltf_.root["scenes"][0]["nodes"] = {1};
    gltf_.push("nodes", {{"children", {0}}});
  }
  json& node(size_t i) { return gltf_.root["nodes"][i]; }

  // Compares every vertex with stills at many times, to within `tolerance`.
  SceneDescription expect_stills(double from, double to, double tolerance = 2e-3) const {
    const SceneDescription open = load_open(gltf_, from, to);
    EXPECT_EQ(test::find_scene_violation(open), "");
    for (int i = 0; i <= 40; ++i) {
      const double share = i / 40.0;
      const SceneDescription still = load_at(gltf_, from + share * (to - from));
      EXPECT_EQ(still.instances.size(), open.instances.size());
      for (size_t instance = 0; instance < still.instances.size(); ++instance) {
        const int mesh = still.instances[instance].mesh;
        for (size_t v = 0; v < still.meshes[size_t(mesh)].positions.size(); ++v) {
          const Vec3d expected = vertex_at(still, instance, v, 0);
          const Vec3d found = vertex_at(open, instance, v, share);
          EXPECT_LE((found - expected).length(), tolerance)
              << "instance " << instance << " vertex " << v << " at " << share;
        }
      }
    }
    return open;
  }

  // Loads the scene at an instant. The scene must be as without velocities, and its vertices in the
  // next frame must be those of a still.
  SceneDescription expect_later(double time, double next_frame, double tolerance = 1e-5) const {
    const test::TempFolder folder;
    GltfOptions options;
    options.time = time;
    options.next_frame = next_frame;
    SceneDescription scene = load_gltf(gltf_.write_glb(folder / "a.glb"), options);
    const SceneDescription now = load_at(gltf_, time), then = load_at(gltf_, time + next_frame);
    EXPECT_EQ(scene.meshes.size(), now.meshes.size());
    for (size_t m = 0; m < now.meshes.size(); ++m) {
      EXPECT_EQ(scene.meshes[m].positions, now.meshes[m].positions);
      EXPECT_EQ(scene.meshes[m].normals, now.meshes[m].normals);
      EXPECT_EQ(scene.meshes[m].triangles, now.meshes[m].triangles);
      EXPECT_TRUE(scene.meshes[m].motion.empty());
    }
    EXPECT_EQ(scene.instances.size(), now.instances.size());
    auto next = scene.next_frame_instances.begin();
    for (uint32_t i = 0; i < scene.instances.size(); ++i) {
      const InstanceDescription& instance = scene.instances[i];
      EXPECT_EQ(instance.to_world, now.instances[i].to_world);
      EXPECT_TRUE(instance.motion.empty());
      Mat44d to_world = instance.to_world;
      if (next != scene.next_frame_instances.end() && next->instance == i)
        to_world = (next++)->to_world;
      const MeshDescription& mesh = scene.meshes[size_t(instance.mesh)];
      for (size_t v = 0; v < mesh.positions.size(); ++v) {
        const Vec3d p(mesh.next_frame.empty() ? mesh.positions[v] : mesh.next_frame.at(v));
        const Vec3d found = transform_point(to_world, p);
        EXPECT_LE((found - vertex_at(then, i, v, 0)).length(), tolerance) << i << " vertex " << v;
      }
    }
    EXPECT_EQ(next, scene.next_frame_instances.end());
    return scene;
  }

  GltfBuilder gltf_;
  int mesh_ = 0;
};

// Adds key frames for `turns` turns about Z, three for each turn.
void spin(GltfBuilder& gltf, int node, double turns, double seconds) {
  std::vector<float> times, rotations;
  const int keys = std::max(1, int(std::lround(3 * turns)));
  for (int k = 0; k <= keys; ++k) {
    times.push_back(float(seconds * k / keys));
    const double half = kPi * turns * k / keys;
    for (const double q : {0.0, 0.0, std::sin(half), std::cos(half)}) rotations.push_back(float(q));
  }
  AnimationBuilder(gltf).move(node, "rotation", times, "VEC4", rotations);
}

TEST_F(GltfShutterTest, ABladeThatTurnsThriceHasItsTurns) {
  spin(gltf_, 1, 3, 1);
  const SceneDescription scene = expect_stills(0, 1);
  EXPECT_TRUE(scene.meshes[0].motion.empty());
  // A step covers at most a quarter turn, and there are no more steps than needed.
  EXPECT_GE(scene.instances[0].motion.size(), 12u);
  EXPECT_LE(scene.instances[0].motion.size(), 16u);
  expect_later(.1, 1 / 24.0);
  expect_later(0, .9);
}

TEST_F(GltfShutterTest, StraightMotionNeedsTwoSteps) {
  AnimationBuilder(gltf_).move(1, "translation", {0, 2}, "VEC3", {0, 0, 0, 8, 4, 0});
  const SceneDescription scene = expect_stills(0.5, 1.5, 1e-6);
  EXPECT_EQ(scene.instances[0].motion.size(), 1u);
}

TEST_F(GltfShutterTest, StaticObjectsHaveNoMotion) {
  gltf_.add_mesh_node(mesh_);
  AnimationBuilder(gltf_).move(1, "translation", {0, 1}, "VEC3", {0, 0, 0, 8, 4, 0});
  const SceneDescription scene = load_open(gltf_, 0, 1);
  EXPECT_FALSE(scene.instances[0].motion.empty());
  EXPECT_TRUE(scene.instances[1].motion.empty());
  // There is no motion after the last key, and none in an instant.
  EXPECT_TRUE(load_open(gltf_, 1, 2).instances[0].motion.empty());
  EXPECT_TRUE(load_open(gltf_, 0.5, 0.5).instances[0].motion.empty());
  EXPECT_EQ(expect_later(0.5, 0.25).next_frame_instances.size(), 1u);
  EXPECT_TRUE(expect_later(1, 0.25).next_frame_instances.empty());
}

TEST_F(GltfShutterTest, KeysWithinTheShutterCount) {
  AnimationBuilder(gltf_).move(1, "translation", {0, 0.3f, 0.31f, 1}, "VEC3",
                               {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 0, 0});
  const SceneDescription scene = load_open(gltf_, 0, 1);
  EXPECT_EQ(scene.instances[0].motion.size(), 64u);  // the maximum
  expect_stills(0, 0.3, 1e-6);
}

TEST_F(GltfShutterTest, SmallObjectsOrbitInACircle) {
  node(0)["translation"] = {30, 0, 0};
  spin(gltf_, 1, 0.1, 1);
  expect_stills(0, 1, 3e-3);
}

TEST_F(GltfShutterTest, SplinesAndScalesAreFollowed) {
  AnimationBuilder(gltf_)
      .move(1, "translation", {0, 1}, "VEC3",
            {0, 0, 0, 0, 0, 0, 9, 0, 0, 0, 9, 0, 3, 3, 0, 0, 0, 0}, "CUBICSPLINE")
      .move(0, "scale", {0, 1}, "VEC3", {1, 1, 1, 3, 0.5f, 2});
  expect_stills(0, 1, 6e-3);  // the triangle grows to 3
}

// Accessors must declare their bounds, but in some files they do not.
TEST_F(GltfShutterTest, AMeshThatDoesNotSayItsSizeIsFollowed) {
  for (json& accessor : gltf_.root["accessors"]) accessor.erase("min");
  node(0)["translation"] = {3, 0, 0};
  spin(gltf_, 1, 0.3, 1);
  expect_stills(0, 1, 5e-3);
}

TEST_F(GltfShutterTest, ObjectsGrowFromNothing) {
  AnimationBuilder(gltf_).move(1, "scale", {0, 1}, "VEC3", {0, 0, 0, 1, 1, 1});
  const SceneDescription scene = load_open(gltf_, 0, 1);
  ASSERT_EQ(scene.instances.size(), 1u);
  EXPECT_NEAR(vertex_at(scene, 0, 1, 0).x, 0, 1e-3);
  EXPECT_NEAR(vertex_at(scene, 0, 1, 0.5).x, 0.5, 1e-3);
  EXPECT_EQ(test::find_scene_violation(scene), "");
  expect_later(0.25, 0.5);
}

// The time is exact to a 64th of the shutter, both for objects that disappear and for those that
// appear.
TEST_F(GltfShutterTest, ObjectsScaledToNothingDisappearAtThatTime) {
  for (const bool comes : {false, true}) {
    GltfBuilder gltf = gltf_;
    AnimationBuilder(gltf).move(
        1, "scale", {0, .3f}, "VEC3",
        comes ? std::vector<float>{0, 0, 0, 1, 1, 1} : std::vector<float>{1, 1, 1, 0, 0, 0},
        "STEP");
    const SceneDescription open = load_open(gltf, 0, 1);
    for (const double time : {.1, .28, .32, .5, .9}) {
      const bool there = comes == (time > .3);
      EXPECT_NEAR(vertex_at(open, 0, 1, time).length(), there ? 1 : 0, 1e-3) << comes << time;
    }
  }
}

TEST_F(GltfShutterTest, ObjectsTurningInsideOutAreFollowed) {
  AnimationBuilder(gltf_).move(1, "scale", {0, 1}, "VEC3", {1, 1, 1, -1, 1, 1});
  const SceneDescription open = load_open(gltf_, 0, 1);
  for (const double time : {.1, .3, .47, .53, .6, .9}) {
    EXPECT_NEAR(vertex_at(open, 0, 1, time).x, 1 - 2 * time, 2e-3) << time;
  }
}

TEST_F(GltfShutterTest, MorphsAndSkinsHaveVerticesInMotion) {
  auto& attributes = gltf_.primitive(mesh_)["attributes"];
  attributes["NORMAL"] = gltf_.add_accessor<float>("VEC3", {0, 0, 1, 0, 0, 1, 0, 0, 1});
  attributes["JOINTS_0"] =
      gltf_.add_accessor<uint8_t>("VEC4", {0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0});
  attributes["WEIGHTS_0"] =
      gltf_.add_accessor<float>("VEC4", {1, 0, 0, 0, 1, 0, 0, 0, 0.25f, 0.75f, 0, 0});
  gltf_.primitive(mesh_)["targets"] = {
      {{"POSITION", gltf_.add_accessor<float>("VEC3", {0, 0, .1f, 0, 0, .2f, 0, 0, .3f})}}};
  const int lower = gltf_.push("nodes", {{"children", {3}}, {"translation", {0, 0, 5}}});
  const int upper = gltf_.push("nodes", {{"translation", {1, 0, 0}}});
  gltf_.add_to_scene(lower);
  gltf_.push("skins", {{"joints", {lower, upper}}});
  node(0)["skin"] = 0;
  const auto half = float(std::sqrt(.5));
  AnimationBuilder(gltf_)
      .move(lower, "rotation", {0, 1}, "VEC4", {0, 0, 0, 1, 0, 0, half, half})
      .move(upper, "rotation", {0, 1}, "VEC4", {0, 0, 0, 1, 0, half, 0, half})
      .move(0, "weights", {0, 0.5f, 1}, "SCALAR", {0, 1, 0});
  const SceneDescription scene = expect_stills(0, 1, 3e-3);
  EXPECT_FALSE(expect_later(.3, .4).meshes[0].next_frame.empty());
  EXPECT_TRUE(scene.instances[0].motion.empty());
  ASSERT_FALSE(scene.meshes[0].motion.empty());
  const MeshStep& last = scene.meshes[0].motion.back();
  const SceneDescription end = load_at(gltf_, 1);
  for (size_t v = 0; v < 3; ++v) {
    EXPECT_LE((last.normals[v] - end.meshes[0].normals[v]).length(), 1e-6f);
  }
}

// Morphed positions move. Other morphed attributes are held, and the coverage lists this.
TEST_F(GltfShutterTest, MorphedColoursAreListedAsHeld) {
  gltf_.primitive(mesh_)["attributes"]["COLOR_0"] =
      gltf_.add_accessor<float>("VEC3", {0, 0, 0, 0, 0, 0, 0, 0, 0});
  gltf_.primitive(mesh_)["targets"] = {
      {{"COLOR_0", gltf_.add_accessor<float>("VEC3", {1, 1, 1, 1, 1, 1, 1, 1, 1})}}};
  AnimationBuilder(gltf_).move(0, "weights", {0, 1}, "SCALAR", {0, 1});
  const auto listed = [](const SceneDescription& scene) {
    return std::ranges::any_of(scene.coverage.approximated, [](const std::string& what) {
      return what.starts_with("morphed colours");
    });
  };
  EXPECT_TRUE(listed(load_open(gltf_, 0, 1)));
  EXPECT_FALSE(listed(load_at(gltf_, .5)));
  EXPECT_FALSE(listed(load_open(gltf_, 1, 2)));  // nothing moves then
}

TEST_F(GltfShutterTest, CamerasAndLightsMoveWithTheirNodes) {
  gltf_.root["cameras"] = {
      {{"type", "perspective"}, {"perspective", {{"yfov", 0.5}, {"znear", 0.1}}}}};
  gltf_.root["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}}};
  node(1)["camera"] = 0;
  node(1)["extensions"]["KHR_lights_punctual"]["light"] = 0;
  AnimationBuilder(gltf_).move(1, "translation", {0, 2}, "VEC3", {0, 0, 0, 4, 0, 2});
  const SceneDescription scene = load_open(gltf_, 0, 1);
  ASSERT_FALSE(scene.cameras.at(0).motion.empty());
  ASSERT_FALSE(scene.lights.at(0).motion.empty());
  EXPECT_EQ(scene.cameras[0].motion.back()[3][0], 2);
  EXPECT_EQ(scene.lights[0].motion.back()[3][2], 1);
  const SceneDescription instant = expect_later(0, .5);
  EXPECT_TRUE(instant.cameras[0].motion.empty());
  EXPECT_TRUE(instant.lights[0].motion.empty());
  EXPECT_EQ(instant.cameras[0].next_frame.value()[3][0], 1);
}

// Two nodes share a mesh. One of them has animated weights, which at this time equal the weights of
// the mesh.
TEST_F(GltfShutterTest, WeightsThatAreAnimatedAreANodesOwn) {
  gltf_.primitive(mesh_)["targets"] = {
      {{"POSITION", gltf_.add_accessor<float>("VEC3", {0, 0, 1, 0, 0, 1, 0, 0, 1})}}};
  gltf_.add_mesh_node(mesh_);
  AnimationBuilder(gltf_).move(0, "weights", {0, 1}, "SCALAR", {0, 1});
  const SceneDescription scene = expect_later(0, .5);
  ASSERT_EQ(scene.meshes.size(), 2u);
  EXPECT_FALSE(scene.meshes[0].next_frame.empty());
  EXPECT_TRUE(scene.meshes[1].next_frame.empty());
}

// A vertex leaves float's range in the next frame. Its triangle exists now and is kept.
TEST_F(GltfShutterTest, TrianglesThatOverflowLaterAreKept) {
  gltf_.primitive(mesh_)["targets"] = {
      {{"POSITION", gltf_.add_accessor<float>("VEC3", {0, 0, 3e38f, 0, 0, 0, 0, 0, 0})}}};
  AnimationBuilder(gltf_).move(0, "weights", {0, 1}, "SCALAR", {0, 9});
  const test::TempFolder folder;
  GltfOptions options;
  options.time = 0;
  options.next_frame = .5;
  const SceneDescription scene = load_gltf(gltf_.write_glb(folder / "a.glb"), options);
  ASSERT_EQ(scene.meshes.at(0).triangles.size(), 1u);
  EXPECT_EQ(scene.meshes[0].next_frame, scene.meshes[0].positions);
}

TEST_F(GltfShutterTest, InstancesOfAMovingNodeMove) {
  node(0)["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] =
      gltf_.add_accessor<float>("VEC3", {0, 0, 0, 5, 0, 0});
  spin(gltf_, 1, 0.25, 1);
  EXPECT_EQ(expect_stills(0, 1).instances.size(), 2u);
}

// The faces are flat and need tangents. Every step has tangents of its own, for the vertices of the
// first step.
TEST_F(GltfShutterTest, TangentsMatchTheStep) {
  gltf_.primitive(mesh_)["targets"] = {
      {{"POSITION", gltf_.add_accessor<float>("VEC3", {0, 0, 0, -1, 1, 0, -1, -1, 0})}}};
  gltf_.primitive(mesh_)["attributes"]["TEXCOORD_0"] =
      gltf_.add_accessor<float>("VEC2", {0, 0, 1, 0, 0, 1});
  AnimationBuilder(gltf_).move(0, "weights", {0, 1}, "SCALAR", {0, 1});
  const test::TempFolder folder;
  GltfOptions options;
  options.time = 0;
  options.shutter = GltfOptions::Shutter{0, 1};
  options.tangents = true;
  const SceneDescription scene = load_gltf(gltf_.write_glb(folder / "a.glb"), options);
  const MeshDescription& mesh = scene.meshes[0];
  ASSERT_FALSE(mesh.motion.empty());
  ASSERT_EQ(mesh.motion.back().tangents.size(), mesh.tangents.size());
  // The edge along u turns from (0, 0) - (1, 0) to (0, 0) - (0, 1).
  EXPECT_NEAR(mesh.tangents[0].x, 1, 1e-6);
  EXPECT_NEAR(mesh.motion.back().tangents[0].y, 1, 1e-6);
  EXPECT_EQ(mesh.motion.back().tangents[0].w, mesh.tangents[0].w);
}

}  // namespace
}  // namespace emberline
