// Tests changes by pointers and visibility while the shutter is open. All values must equal those
// of a still.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "renderer/core/constants.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "support/animated_gltf.h"
#include "support/loaded_gltf.h"
#include "support/processor_time.h"
#include "support/scene_validation.h"

namespace emberline {
namespace {

using nlohmann::json;
using test::AnimationBuilder;
using test::GltfBuilder;
using test::load_at;
using test::load_open;

constexpr const char* kLight = "/extensions/KHR_lights_punctual/lights/0";

// The file has a triangle in node 0, a spot light in node 1 and a camera in node 2.
class GltfChangesTest : public testing::Test {
 protected:
  GltfChangesTest() {
    gltf_.add_triangle();
    json& positions = gltf_.root["accessors"][0];
    positions["min"] = {0, 0, 0};
    positions["max"] = {1, 1, 0};
    gltf_.root["materials"] = {
        {{"emissiveFactor", {0.5, 0.25, 1}},
         {"extensions", {{"KHR_materials_emissive_strength", {{"emissiveStrength", 4}}}}}}};
    gltf_.primitive(0)["material"] = 0;
    gltf_.root["extensions"]["KHR_lights_punctual"]["lights"] = {
        {{"type", "spot"},
         {"color", {1, 0.5, 0.25}},
         {"intensity", 8},
         {"range", 5},
         {"spot", {{"innerConeAngle", 0.1}, {"outerConeAngle", 0.5}}}}};
    gltf_.root["cameras"] = {
        {{"type", "perspective"}, {"perspective", {{"yfov", 0.5}, {"znear", 0.1}}}}};
    gltf_.push("nodes", {{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
    gltf_.push("nodes", {{"camera", 0}});
    gltf_.add_to_scene(1);
    gltf_.add_to_scene(2);
  }
  void hide(int node, const std::vector<float>& times, const std::vector<uint8_t>& visible) {
    gltf_.root["nodes"][size_t(node)]["extensions"]["KHR_node_visibility"] = {{"visible", true}};
    AnimationBuilder(gltf_, "").point(
        "/nodes/" + std::to_string(node) + "/extensions/KHR_node_visibility/visible", times, "BOOL",
        visible, "STEP");
  }

  static Rgb light_at(const PunctualLightDescription& light, float share) {
    if (light.visibility && !light.visibility->at(share)) return Rgb(0.0f);
    return light.share ? light.intensity * light.share->at(share) : light.intensity;
  }
  // Compares the scene with stills at many times, which are slightly off the key frames.
  // `tolerance` is relative to the largest value.
  void expect_stills(double from, double to, float tolerance) const {
    const SceneDescription open = load_open(gltf_, from, to);
    const PunctualLightDescription& light = open.lights.at(0);
    const MaterialDescription& material = open.materials.at(0);
    const CameraDescription& camera = open.cameras.at(0);
    const auto expect_near = [&](const Rgb& found, const Rgb& expected, const Rgb& most,
                                 float share) {
      EXPECT_LE(max_abs_component(found - expected), tolerance * max_component(most))
          << found << " for " << expected << " at " << share;
    };
    for (int i = 0; i < 200; ++i) {
      const float share = (float(i) + 0.517f) / 200;
      const SceneDescription still = load_at(gltf_, from + double(share) * (to - from));
      expect_near(light_at(light, share), light_at(still.lights.at(0), 0), light.intensity, share);
      expect_near(material.emission_scale ? material.emission * material.emission_scale->at(share)
                                          : material.emission,
                  still.materials.at(0).emission, material.emission, share);
      const Vec2f cones =
          light.cones ? light.cones->at(share) : Vec2f(light.inner_cone, light.outer_cone);
      EXPECT_NEAR(cones.x, still.lights[0].inner_cone, tolerance) << share;
      EXPECT_NEAR(cones.y, still.lights[0].outer_cone, tolerance) << share;
      const float range =
          light.range_scale ? light.range * light.range_scale->at(share) : light.range;
      EXPECT_NEAR(range, still.lights[0].range, tolerance * light.range) << share;
      EXPECT_NEAR(camera.zoom ? camera.zoom->at(share) : camera.fov_y, still.cameras.at(0).fov_y,
                  double(tolerance))
          << share;
    }
  }

  GltfBuilder gltf_;
};

TEST_F(GltfChangesTest, StepsAreExact) {
  AnimationBuilder(gltf_)
      .point(std::string(kLight) + "/intensity", {0, 0.3f, 0.8f, 1.5f}, "SCALAR", {0, 5, 1, 0},
             "STEP")
      .point("/materials/0/emissiveFactor", {0, 0.4f, 0.5f}, "VEC3", {0, 0, 0, 1, 1, 0, 0, 0, 1},
             "STEP")
      .point(std::string(kLight) + "/spot/outerConeAngle", {0.5f, 0.7f}, "SCALAR", {0.6f, 0.3f},
             "STEP")
      .point(std::string(kLight) + "/range", {0.2f, 0.6f}, "SCALAR", {4, 2}, "STEP")
      .point("/cameras/0/perspective/yfov", {0.1f, 0.7f}, "SCALAR", {0.6f, 0.3f}, "STEP");
  expect_stills(0, 1, 1e-6f);
  expect_stills(0.25, 0.75, 1e-6f);
  const SceneDescription scene = load_open(gltf_, 0, 1);
  EXPECT_EQ(scene.lights[0].intensity, Rgb(5, 2.5f, 1.25f));
  EXPECT_EQ(scene.lights[0].share->times, (std::vector<float>{0, 0.3f, 0.3f, 0.8f, 0.8f, 1}));
  EXPECT_EQ(scene.materials[0].emission, Rgb(4.0f));
  EXPECT_EQ(test::find_scene_violation(scene), "");
}

// There is one warning per file, with or without a shutter, and only if the value occurs at the
// loaded time.
TEST_F(GltfChangesTest, ValuesBeyondTheirBoundsAreWarnedOf) {
  const std::string outer = std::string(kLight) + "/spot/outerConeAngle";
  AnimationBuilder(gltf_)
      .point(outer, {0, 1, 2}, "SCALAR", {0.5f, 0.6f, 2.5f})
      .point(std::string(kLight) + "/intensity", {0, 1, 2}, "SCALAR", {1, 1, -3}, "STEP");
  const auto warnings_of = [&](const auto& read) {
    std::vector<std::string> warnings;
    set_log_sink([&](LogKind, std::string_view message) { warnings.emplace_back(message); });
    const SceneDescription scene = read();
    set_log_sink(nullptr);
    EXPECT_LE(scene.lights.at(0).outer_cone, float(kPiD / 2));
    std::erase_if(warnings, [](const std::string& s) { return s.find("clamped") == s.npos; });
    return warnings;
  };
  EXPECT_TRUE(warnings_of([&] { return load_at(gltf_, 1); }).empty());
  EXPECT_TRUE(warnings_of([&] { return load_open(gltf_, 0.2, 0.9); }).empty());
  const auto still = warnings_of([&] { return load_at(gltf_, 2); });
  ASSERT_EQ(still.size(), 1u);
  EXPECT_NE(still[0].find("clamped: " + outer + ", " + kLight + "/intensity"), std::string::npos)
      << still[0];
  const auto open = warnings_of([&] { return load_open(gltf_, 1, 1.9); });
  ASSERT_EQ(open.size(), 1u);
  EXPECT_TRUE(open[0].ends_with("clamped: " + outer)) << open[0];
}

TEST_F(GltfChangesTest, ProductsOfStraightLinesAndSplines) {
  AnimationBuilder(gltf_)
      .point(std::string(kLight) + "/intensity", {0, 0.3f, 1}, "SCALAR", {0, 5, 1})
      .point(std::string(kLight) + "/color", {0, 1}, "VEC3", {1, 0, 0, 0, 1, 0.5f})
      .point("/materials/0/emissiveFactor", {0, 1}, "VEC3", {0, 1, 0, 1, 0, 1})
      .point("/materials/0/extensions/KHR_materials_emissive_strength/emissiveStrength",
             {0.2f, 0.9f}, "SCALAR", {0, 1, 0, 0, 10, 0}, "CUBICSPLINE")
      .point(std::string(kLight) + "/spot/innerConeAngle", {0, 1}, "SCALAR", {0.01f, 0.9f})
      .point(std::string(kLight) + "/range", {0, 0.5f, 1}, "SCALAR", {0.5f, 7, 0.5f})
      .point("/cameras/0/perspective/yfov", {0, 1}, "SCALAR", {0, 0.2f, 3, 0, 1, 0}, "CUBICSPLINE");
  expect_stills(0, 1, 1.5e-3f);
  expect_stills(0.4, 0.6, 1.5e-3f);
}

TEST_F(GltfChangesTest, InvalidRangeIsInfinite) {
  AnimationBuilder(gltf_).point(std::string(kLight) + "/range", {0, 0.5f}, "SCALAR", {-1, 4},
                                "STEP");
  EXPECT_EQ(load_at(gltf_, 0.25).lights.at(0).range, std::numeric_limits<float>::infinity());
  EXPECT_EQ(load_at(gltf_, 0.75).lights.at(0).range, 4.0f);
  const PunctualLightDescription light = load_open(gltf_, 0, 1).lights.at(0);
  EXPECT_GE(light.range * light.range_scale->at(0.25f), 1e17f);
  EXPECT_FLOAT_EQ(light.range * light.range_scale->at(0.75f), 4.0f);
}

TEST_F(GltfChangesTest, ConstantValuesHaveNoCurve) {
  AnimationBuilder(gltf_)
      .point(std::string(kLight) + "/intensity", {0, 0.3f, 0.6f, 2}, "SCALAR", {5, 5, 5, 0})
      .point("/materials/0/emissiveFactor", {0, 1}, "VEC3", {0, 0, 0, 0, 0, 0});
  const SceneDescription scene = load_open(gltf_, 0, 0.5);
  EXPECT_EQ(scene.lights[0].intensity, Rgb(5, 2.5f, 1.25f));
  EXPECT_EQ(scene.lights[0].share, nullptr);
  EXPECT_EQ(scene.lights[0].cones, nullptr);
  EXPECT_EQ(scene.lights[0].range_scale, nullptr);
  EXPECT_EQ(scene.cameras[0].zoom, nullptr);
  EXPECT_EQ(scene.materials[0].emission, Rgb(0.0f));
  EXPECT_EQ(scene.materials[0].emission_scale, nullptr);
  EXPECT_EQ(scene.instances[0].visibility, nullptr);
  // A shutter of zero length is an instant, even if it is at another time than requested.
  const test::TempFolder folder;
  GltfOptions options;
  options.time = 0;
  options.shutter = GltfOptions::Shutter{1.3, 1.3};
  const SceneDescription still = load_gltf(gltf_.write_glb(folder / "a.glb"), options);
  EXPECT_NEAR(still.lights[0].intensity.x, 2.5, 1e-5);
  EXPECT_EQ(still.lights[0].share, nullptr);
}

TEST_F(GltfChangesTest, OthersAreHeldAndSaid) {
  gltf_.root["materials"][0]["pbrMetallicRoughness"] = {{"roughnessFactor", 0.5}};
  AnimationBuilder(gltf_).point("/materials/0/pbrMetallicRoughness/roughnessFactor", {0, 1},
                                "SCALAR", {0, 1});
  const SceneDescription open = load_open(gltf_, 0.25, 0.5);
  EXPECT_EQ(open.materials[0].roughness, 0.25f);
  EXPECT_EQ(open.coverage.approximated,
            std::vector<std::string>{"animated material values (held while the shutter is open)"});
  EXPECT_TRUE(load_open(gltf_, 2, 3).coverage.approximated.empty());
  EXPECT_TRUE(load_at(gltf_, 0.5).coverage.approximated.empty());
}

TEST_F(GltfChangesTest, ChildrenAreSeenWhileTheirParentsAre) {
  gltf_.push("nodes", {{"children", {0, 1}}});
  gltf_.root["scenes"][0]["nodes"] = {3, 2};
  gltf_.root["animations"] = json::array();
  const char* visible = "/extensions/KHR_node_visibility/visible";
  for (const size_t node : {0, 1, 3}) {
    gltf_.root["nodes"][node]["extensions"]["KHR_node_visibility"] = {{"visible", true}};
  }
  AnimationBuilder(gltf_)
      .point<uint8_t>(std::string("/nodes/3") + visible, {0, 0.25f, 0.75f}, "BOOL", {0, 1, 0},
                      "STEP")
      .point<uint8_t>(std::string("/nodes/0") + visible, {0, 0.5f, 0.9f}, "BOOL", {1, 0, 1}, "STEP")
      .point<uint8_t>(std::string("/nodes/1") + visible, {0, 0.5f}, "BOOL", {0, 1}, "STEP");
  const SceneDescription scene = load_open(gltf_, 0, 1);
  ASSERT_TRUE(scene.instances.at(0).visibility);
  EXPECT_FALSE(scene.instances[0].visibility->visible_at_open);
  EXPECT_EQ(scene.instances[0].visibility->toggle_times, (std::vector<float>{0.25f, 0.5f}));
  EXPECT_EQ(scene.lights.at(0).visibility->toggle_times, (std::vector<float>{0.5f, 0.75f}));
  expect_stills(0.51, 0.74, 1e-6f);
  // The light is hidden during the whole shutter.
  EXPECT_EQ(load_open(gltf_, 0.3, 0.4).instances.at(0).visibility, nullptr);
  EXPECT_TRUE(load_open(gltf_, 0.3, 0.4).lights.empty());
}

TEST_F(GltfChangesTest, AnimationMayHideEverything) {
  hide(0, {0, 1}, {0, 1});
  const SceneDescription empty = load_at(gltf_, 0.5);
  EXPECT_TRUE(empty.instances.empty());
  EXPECT_EQ(test::find_scene_violation(empty), "");
  // The empty scene has the bounds of the object while it is visible.
  ASSERT_TRUE(empty.rest_bounds);
  EXPECT_EQ(empty.rest_bounds->center(), load_at(gltf_, 1.5).rest_bounds->center());
  EXPECT_EQ(load_open(gltf_, 0.5, 1.5).instances.at(0).visibility->toggle_times,
            std::vector<float>{0.5f});
  // If the object is always hidden, the file also loads, and shows only the environment.
  gltf_.root["animations"] = json::array();
  gltf_.root["nodes"][0]["extensions"]["KHR_node_visibility"]["visible"] = false;
  AnimationBuilder(gltf_).point(std::string(kLight) + "/intensity", {0, 1}, "SCALAR", {0, 5});
  EXPECT_TRUE(load_at(gltf_, 0.5).instances.empty());
}

TEST_F(GltfChangesTest, InvalidValueIsRefusedIfNeeded) {
  AnimationBuilder(gltf_).point("/cameras/0/perspective/yfov", {0, 0.5f, 1}, "SCALAR",
                                {0.5f, -1, 0.5f});
  EXPECT_TRUE(load_open(gltf_, 0, 1).cameras.at(0).fault);
  gltf_.root["animations"] = json::array();
  AnimationBuilder(gltf_)
      .point(std::string(kLight) + "/intensity", {0, 1}, "SCALAR", {1, 3e38f})
      .point(std::string(kLight) + "/color", {0, 1}, "VEC3", {1, 1, 1, 9, 9, 9});
  EXPECT_TRUE(load_open(gltf_, 0, 1).lights.empty());  // left out, with a warning
}

// ---- hostile ------------------------------------------------------------------------------------

std::vector<float> many_times(size_t count) {
  std::vector<float> times;
  for (size_t i = 0; i < count; ++i) times.push_back(float(i) / float(count));
  return times;
}

TEST_F(GltfChangesTest, AMillionKeyFramesWithinTheShutter) {
  constexpr size_t kKeys = 1'000'000;
  std::vector<float> values;
  for (size_t i = 0; i < kKeys; ++i) values.push_back(float(i % 7));
  AnimationBuilder(gltf_)
      .point(std::string(kLight) + "/intensity", many_times(kKeys), "SCALAR", values)
      .point("/materials/0/extensions/KHR_materials_emissive_strength/emissiveStrength",
             many_times(kKeys), "SCALAR", values, "STEP");
  const double begin = test::processor_seconds();
  const SceneDescription scene = load_open(gltf_, 0, 1);
  const double taken = test::processor_seconds() - begin;
  EXPECT_EQ(scene.lights[0].intensity.x, 6);
  EXPECT_LE(scene.lights[0].share->times.size(), kKeys + 1);
  EXPECT_LE(scene.materials[0].emission_scale->times.size(), 2 * kKeys);
  EXPECT_LT(taken, 60);  // quadratic work would take days
}

TEST_F(GltfChangesTest, VisibilityThatIsSwitchedAHundredThousandTimes) {
  constexpr size_t kKeys = 100'000;
  std::vector<uint8_t> values;
  for (size_t i = 0; i < kKeys; ++i) values.push_back(uint8_t(i % 2));
  hide(0, many_times(kKeys), values);
  // The object is under a chain of nodes with the same animation.
  const json visibility = {{"KHR_node_visibility", {{"visible", true}}}};
  json& animation = gltf_.root["animations"][0];
  int child = 0;
  for (int i = 0; i < 1000; ++i) {
    child = gltf_.push("nodes", {{"children", {child}}, {"extensions", visibility}});
    json channel = animation["channels"][0];
    channel["target"]["extensions"]["KHR_animation_pointer"]["pointer"] =
        "/nodes/" + std::to_string(child) + "/extensions/KHR_node_visibility/visible";
    animation["channels"].push_back(channel);
  }
  gltf_.root["scenes"][0]["nodes"] = {child, 1, 2};
  const SceneDescription scene = load_open(gltf_, 0, 1);
  EXPECT_EQ(scene.instances.at(0).visibility->toggle_times.size(), kKeys - 1);
}

TEST_F(GltfChangesTest, SharedKeyFramesAreLimitedByTheFileSize) {
  // There are 2000 lights with 20,000 key frames each.
  constexpr size_t kKeys = 20'000;
  std::vector<float> values;
  for (size_t i = 0; i < kKeys; ++i) values.push_back(float(i % 7));
  AnimationBuilder builder(gltf_);
  builder.point(std::string(kLight) + "/intensity", many_times(kKeys), "SCALAR", values, "STEP");
  json& lights = gltf_.root["extensions"]["KHR_lights_punctual"]["lights"];
  for (size_t i = 1; i < 2000; ++i) {
    lights.push_back(lights[0]);
    json channel = builder.channel(0);
    channel["target"]["extensions"]["KHR_animation_pointer"]["pointer"] =
        "/extensions/KHR_lights_punctual/lights/" + std::to_string(i) + "/intensity";
    builder.object()["channels"].push_back(channel);
  }
  EXPECT_THROW(load_open(gltf_, 0, 1), InputError);
}

}  // namespace
}  // namespace emberline
