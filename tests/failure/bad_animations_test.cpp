// An invalid animation is an error if the render uses it. Otherwise it causes a warning, or
// nothing.
#include <cmath>
#include <ctime>
#include <limits>
#include <nlohmann/json.hpp>

#include "failure/bad_input.h"
#include "support/animated_gltf.h"

namespace emberline {
namespace {

using nlohmann::json;
using test::AnimationBuilder;
using test::expect_input_error;
using test::expect_warning;
using test::GltfBuilder;
using test::TempFolder;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

class BadAnimation : public testing::Test {
 protected:
  BadAnimation() {
    gltf_.add_triangle();
    gltf_.primitive()["targets"] = {
        {{"POSITION", gltf_.add_accessor<float>("VEC3", {0, 0, 1, 0, 0, 1, 0, 0, 1})}},
        {{"POSITION", gltf_.add_accessor<float>("VEC3", {0, 1, 0, 0, 1, 0, 0, 1, 0})}}};
  }

  // Channel 0 moves the triangle; `damage` then damages the animation.
  template <class Damage>
  GltfBuilder damaged(const Damage& damage) const {
    GltfBuilder gltf = gltf_;
    AnimationBuilder animation(gltf);
    animation.move(0, "translation", {0, 1, 2}, "VEC3", {0, 0, 0, 1, 1, 1, 2, 2, 2});
    damage(animation);
    return gltf;
  }
  // Faults in the JSON are always found. Faults in the key frames are found only when the key
  // frames are read.
  template <class Damage>
  void expect_json_fault(const std::vector<std::string>& parts, const Damage& damage) const {
    expect_warning(damaged(damage), parts);
    expect_input_error(damaged(damage), parts, {.time = 0.5});
  }
  template <class Damage>
  void expect_key_fault(const std::vector<std::string>& parts, const Damage& damage) const {
    EXPECT_FALSE(load_without_checks(damaged(damage)).instances.empty());
    expect_input_error(damaged(damage), parts, {.time = 0.5});
  }
  static SceneDescription load_without_checks(const GltfBuilder& gltf,
                                              const GltfOptions& options = {}) {
    const TempFolder folder;
    return load_gltf(gltf.write_glb(folder / "a.glb"), options);
  }
  static AnimationBuilder& turn(AnimationBuilder& a, const std::vector<float>& values) {
    return a.move(0, "rotation", {0, 1}, "VEC4", values);
  }

  GltfBuilder gltf_;
};

TEST_F(BadAnimation, KeyTimes) {
  const auto times = [&](const std::vector<float>& values, const std::string& message) {
    expect_key_fault({"#/animations/0/samplers/1/input: " + message}, [&](AnimationBuilder& a) {
      a.move(0, "scale", values, "VEC3", std::vector<float>(values.size() * 3, 1.0f));
    });
  };
  times({0, 1, 0.5f}, "key times must increase: key frame 1 is at 1 s, the next at 0.5 s");
  times({0, 1, 1}, "key times must increase: key frame 1");
  times({0, kNaN, 1}, "element 1 is not a finite number");
  times({0, INFINITY}, "element 1 is not a finite number");
  times({-1, 1}, "the first key frame is at -1 s");
}

TEST_F(BadAnimation, Values) {
  expect_key_fault({"#/animations/0/samplers/1/output: element 1 is not a finite number"},
                   [&](AnimationBuilder& a) {
                     turn(a, {0, 0, 0, 1, 0, kNaN, 0, 1});
                   });
  expect_key_fault({"#/animations/0/samplers/1/output: the rotation of key frame 1 is zero"},
                   [&](AnimationBuilder& a) {
                     turn(a, {0, 0, 0, 1, 0, 0, 0, 0});
                   });
  const GltfBuilder longer = damaged([&](AnimationBuilder& a) {
    turn(a, {0, 0, 0, 2, 0, 0, 5, 0});
  });
  expect_warning(longer, {"#/animations/0/samplers/1/output: 2 rotations", "are normalised"},
                 {.time = 0.0});
  // The tangents of a spline need not be rotations.
  load_without_checks(
      damaged([](AnimationBuilder& a) {
        a.move(0, "rotation", {0}, "VEC4", {0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0}, "CUBICSPLINE");
      }),
      {.time = 0.0});
}

TEST_F(BadAnimation, Counts) {
  expect_json_fault(
      {"#/animations/0/samplers/1/output: found 2 values for 3 key frames, expected 3"},
      [](AnimationBuilder& a) {
        a.move(0, "scale", {0, 1, 2}, "VEC3", {1, 1, 1, 2, 2, 2});
      });
  expect_json_fault(
      {"#/animations/0/samplers/1/output: found 2 values for 2 key frames, expected 6"},
      [](AnimationBuilder& a) {
        a.move(0, "scale", {0, 1}, "VEC3", {1, 1, 1, 2, 2, 2}, "CUBICSPLINE");
      });
  expect_json_fault(
      {"#/animations/0/samplers/1/output: found 3 values for 2 key frames, expected 4"},
      [](AnimationBuilder& a) {
        a.move(0, "weights", {0, 1}, "SCALAR", {1, 2, 3});
      });
}

TEST_F(BadAnimation, Types) {
  expect_json_fault({"#/animations/0/samplers/1/output: the accessor has 4 components, expected 3"},
                    [](AnimationBuilder& a) {
                      a.move(0, "scale", {0}, "VEC4", {1, 1, 1, 1});
                    });
  expect_json_fault({"#/animations/0/samplers/1/output: expected floats"}, [](AnimationBuilder& a) {
    a.move<int16_t>(0, "scale", {0}, "VEC3", {1, 1, 1});
  });
  expect_json_fault(
      {"#/animations/0/samplers/0/output: expected floats, or normalized integers"},
      [](AnimationBuilder& a) {
        a.channel(0)["target"]["path"] = "rotation";
        a.output(0) = {{"bufferView", 0}, {"componentType", 5121}, {"count", 3}, {"type", "VEC4"}};
      });
  expect_json_fault(
      {"#/animations/0/samplers/0/input: expected an accessor of SCALAR floats"},
      [](AnimationBuilder& a) { a.input(0)["type"] = "VEC2", a.input(0)["count"] = 1; });
  expect_json_fault({"#/animations/0/samplers/0/interpolation: unknown interpolation \"SPLINE\""},
                    [](AnimationBuilder& a) { a.sampler(0)["interpolation"] = "SPLINE"; });
}

TEST_F(BadAnimation, Structure) {
  expect_json_fault({"#/animations/0/channels/0/sampler: index 5 is out of range"},
                    [](AnimationBuilder& a) { a.channel(0)["sampler"] = 5; });
  expect_json_fault({"#/animations/0/channels/0/target/node: index 9 is out of range"},
                    [](AnimationBuilder& a) { a.channel(0)["target"]["node"] = 9; });
  expect_json_fault({"#/animations/0/samplers/0/input: index 99 is out of range"},
                    [](AnimationBuilder& a) { a.sampler(0)["input"] = 99; });
  expect_json_fault({"#/animations/0: the required member \"channels\" is missing"},
                    [](AnimationBuilder& a) { a.object().erase("channels"); });
  expect_json_fault({"#/animations/0/channels/0/target: the required member \"path\" is missing"},
                    [](AnimationBuilder& a) { a.channel(0)["target"].erase("path"); });
  GltfBuilder none = gltf_;
  none.root["animations"] = 7;
  expect_warning(none, {"#/animations: expected an array"});
  expect_input_error(none, {"#/animations: expected an array"}, {.time = 0.0});
}

TEST_F(BadAnimation, Targets) {
  expect_json_fault({"#/animations/0/channels/1/target: /nodes/0/translation is animated twice"},
                    [](AnimationBuilder& a) {
                      a.move(0, "translation", {0}, "VEC3", {1, 1, 1});
                    });
  expect_json_fault({"#/animations/0/channels/1/target: /nodes/0/translation is animated twice"},
                    [](AnimationBuilder& a) {
                      a.point("/nodes/0/translation", {0}, "VEC3", {1, 1, 1});
                    });
  for (const bool whole_first : {false, true}) {
    expect_json_fault({"#/animations/0/channels/2/target: /nodes/0/weights", "is animated twice"},
                      [&](AnimationBuilder& a) {
                        if (whole_first) a.move(0, "weights", {0}, "SCALAR", {1, 1});
                        a.point("/nodes/0/weights/1", {0}, "SCALAR", {1});
                        if (!whole_first) a.move(0, "weights", {0}, "SCALAR", {1, 1});
                      });
  }
  gltf_.push("nodes", json::object());
  expect_json_fault(
      {"#/animations/0/channels/1/target/path: node 1 has no mesh with morph targets"},
      [](AnimationBuilder& a) { a.move(1, "weights", {0}, "SCALAR", {1}); });
  gltf_.root["nodes"][1]["matrix"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  expect_json_fault({"#/animations/0/channels/1/target/path: node 1 has a matrix"},
                    [](AnimationBuilder& a) {
                      a.move(1, "scale", {0}, "VEC3", {1, 1, 1});
                    });
  gltf_.root["nodes"][1]["extensions"]["KHR_node_visibility"]["visible"] = true;
  const std::string visible = "/nodes/1/extensions/KHR_node_visibility/visible";
  expect_json_fault({"#/animations/0/samplers/1/output: expected unsigned bytes"},
                    [&](AnimationBuilder& a) { a.point(visible, {0}, "SCALAR", {1}, "STEP"); });
  expect_json_fault({"#/animations/0/samplers/1/interpolation: expected STEP"},
                    [&](AnimationBuilder& a) { a.point<uint8_t>(visible, {0}, "BOOL", {1}); });
}

// An animation whose bytes are missing is only an error if it is used.
TEST_F(BadAnimation, WithoutItsBytes) {
  expect_json_fault(
      {"#/accessors/", "1000 elements of 12 bytes", "do not fit into the buffer view"},
      [](AnimationBuilder& a) { a.output(0)["count"] = 1000; });
}

TEST_F(BadAnimation, CountsTooLargeForTheFile) {
  const test::MemoryLimit limit(uint64_t(4) << 30);
  expect_key_fault({"too many for a file of this size"}, [](AnimationBuilder& a) {
    a.input(0) = {{"componentType", 5126}, {"count", uint64_t(1) << 40}, {"type", "SCALAR"}};
    a.output(0) = {{"componentType", 5126}, {"count", uint64_t(1) << 40}, {"type", "VEC3"}};
  });
}

// A million keys that three thousand channels share are read once.
TEST_F(BadAnimation, SharedKeysAreReadOnce) {
  constexpr size_t kKeys = 1000000, kChannels = 3000;
  GltfBuilder gltf = gltf_;
  std::vector<float> times(kKeys), values(kKeys * 3, 1.0f);
  for (size_t i = 0; i < kKeys; ++i) times[i] = float(i);
  AnimationBuilder animation(gltf);
  animation.move(0, "scale", times, "VEC3", values);
  json& channels = animation.object()["channels"];
  for (size_t i = 1; i < kChannels; ++i) {
    channels.push_back(
        {{"sampler", 0},
         {"target", {{"node", gltf.push("nodes", json::object())}, {"path", "scale"}}}});
  }
  const std::clock_t start = std::clock();
  EXPECT_FALSE(load_without_checks(gltf, {.time = 1234.5}).instances.empty());
  EXPECT_LT(double(std::clock() - start) / CLOCKS_PER_SEC, 20.0);
  // The memory budget counts keys before they are read.
  const TempFolder folder;
  const std::string path = gltf.write_glb(folder / "a.glb");
  const auto load_within = [&](uint64_t bytes, const GltfOptions& options) {
    const auto budget = std::make_shared<MemoryBudget>(bytes);
    LoadProgress progress({}, {}, {budget, std::nullopt, path});
    load_gltf(path, options, progress);
    return budget->peak();
  };
  const uint64_t at_rest = load_within(uint64_t(1) << 40, {});
  EXPECT_GT(load_within(uint64_t(1) << 40, {.time = 0.0}), at_rest + kKeys * 4);
  EXPECT_THROW(load_within(at_rest + kKeys * 4, {.time = 0.0}), InputError);
}

}  // namespace
}  // namespace emberline
