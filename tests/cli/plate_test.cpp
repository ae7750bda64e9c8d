// Tests --catcher and --holdout, which name objects for compositing over a plate. Also tests
// refused options, merge, resume and extend.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "cli/command_test.h"
#include "support/animated_gltf.h"

namespace emberline::test {
namespace {

class PlateOptions : public CommandTest {
 protected:
  // The scene has a floor, a lamp, and a card above the floor. The card's node has a parent.
  void SetUp() override {
    GltfBuilder gltf = lamp_scene();
    const int card = gltf.push("materials", {{"name", "card"}, {"doubleSided", true}});
    add_quad(gltf, {-0.5f, 0.4f, 0.4f}, {1, 0, 0}, {0, 0, -0.8f}, card);
    auto& nodes = gltf.root["nodes"];
    const size_t last = nodes.size();
    for (auto& node : nodes) {
      if (node.contains("mesh") && !node.contains("name")) node["name"] = "plain";
    }
    nodes[last - 1]["name"] = "card, \"quoted\"\n" + std::string(300, 'x');
    nodes.push_back({{"name", "props"}, {"children", {last - 1}}});
    auto& roots = gltf.root["scenes"][0]["nodes"];
    for (auto& root : roots) {
      if (root == last - 1) root = last;
    }
    for (auto& node : nodes) {
      if (node.value("mesh", -1) == 0) node["name"] = "floor";
    }
    nodes.push_back({{"name", "nothing"}});
    gltf.write_glb(path("scene.glb"));
  }
  Words frame(const Words& more) {
    return Words{"render",
                 path("scene.glb"),
                 "-o",
                 path("out.exr"),
                 "--size",
                 "24x18",
                 "--bucket-size",
                 "8",
                 "--catcher",
                 "floor",
                 "--camera",
                 "main",
                 "--transparent"} +
           more;
  }
  ExrPicture picture(const Words& more) {
    render(frame(more));
    return read_exr(path("out.exr"));
  }
};

TEST_F(PlateOptions, GoThroughCheckpoints) {
  const ExrPicture whole = picture({"--spp", "8"});
  const std::vector<float>&shadow = whole.channels.at("shadow.G"), &alpha = whole.channels.at("A");
  EXPECT_LT(std::ranges::min(shadow), 0.5f);
  EXPECT_EQ(std::ranges::max(shadow), 1.0f);
  EXPECT_GT(std::ranges::count_if(alpha, [](float a) { return a > 0.05f && a < 0.95f; }), 10);

  for (const char* part : {"1/2", "2/2"}) render(frame({"--spp", "8", "--part", part}));
  render({"merge", "-o", path("merged.exr"), path("out.exr.part-1-of-2.checkpoint"),
          path("out.exr.part-2-of-2.checkpoint")});
  EXPECT_EQ(first_difference(whole, read_exr(path("merged.exr"))), "");

  for (const char* range : {"0-3", "3-8"}) render(frame({"--sample-range", range}));
  render({"merge", "-o", path("ranges.exr"), path("out.exr.samples-0-3.checkpoint"),
          path("out.exr.samples-3-8.checkpoint")});
  const ExrPicture ranges = read_exr(path("ranges.exr"));
  for (const auto& [name, values] : whole.channels) {
    for (size_t i = 0; i < values.size(); ++i) {
      ASSERT_NEAR(ranges.channels.at(name)[i], values[i], 2e-6f) << name << ", " << i;
    }
  }

  render(frame({"--spp", "4", "--resumable"}));
  render({"extend", path("out.exr"), "--spp", "8", "-o", path("extended.exr")});
  EXPECT_EQ(first_difference(whole, read_exr(path("extended.exr"))), "");

  render(frame({"--spp", "8", "--resumable", "--driver", "bisection"}));
  expect_failure(frame({"--spp", "8", "--resume", "--driver", "bisection", "--holdout", "props"}),
                 3, {"--holdout: not given (now props)"});
}

// The rounds of the adaptive driver have different weights, but shadows are computed from all
// samples.
TEST_F(PlateOptions, WorkWithEveryDriver) {
  const ExrPicture whole = picture({"--spp", "64"});
  for (const Words& driver :
       {Words{"--driver", "bisection"}, Words{"--driver", "adaptive"},
        Words{"--driver", "adaptive", "--unbiased"}, Words{"--noise-threshold", "0.02"}}) {
    const ExrPicture other = picture(Words{"--spp", "64"} + driver);
    for (const char* channel : {"A", "shadow.G"}) {
      double difference = 0;
      for (size_t i = 0; i < whole.channels.at(channel).size(); ++i) {
        difference += double(whole.channels.at(channel)[i] - other.channels.at(channel)[i]);
      }
      EXPECT_LT(std::abs(difference) / (24 * 18), 0.02) << driver.back() << ", " << channel;
    }
  }
}

// The options can name an object by its parent node, and by a name with special characters.
TEST_F(PlateOptions, NameNodes) {
  const ExrPicture plain = picture({"--spp", "4", "--aov", "id"});
  const ExrPicture held = picture({"--spp", "4", "--aov", "id", "--holdout", "props"});
  EXPECT_NE(first_difference(plain, held), "");
  const std::string name = "card\\, \"quoted\"\n" + std::string(300, 'x');
  EXPECT_EQ(first_difference(held, picture({"--spp", "4", "--aov", "id", "--holdout", name})), "");
  const Words frame_of_two = {"--spp", "4", "--holdout", "props,plain"};
  EXPECT_EQ(first_difference(picture(frame_of_two),
                             picture({"--spp", "4", "--holdout", "props", "--holdout", "plain"})),
            "");
  render(frame({"--spp", "4", "--holdout", "props", "--save-settings", path("look.json")}));
  render({"render", path("scene.glb"), "--settings", path("look.json"), "-o", path("again.exr")});
  EXPECT_EQ(first_difference(read_exr(path("out.exr")), read_exr(path("again.exr"))), "");
}

// The plane stands in for a floor of the file. The floor ends where the plane has no shadows any
// more.
TEST_F(PlateOptions, APlaneCatchesLikeAFloor) {
  GltfBuilder lamp;
  const int bright = lamp.push("materials", {{"emissiveFactor", {1, 1, 1}}, {"doubleSided", true}});
  const int dark =
      lamp.push("materials", {{"pbrMetallicRoughness", {{"baseColorFactor", {0, 0, 0, 1}}}}});
  add_quad(lamp, {-0.5f, 1, -0.5f}, {1, 0, 0}, {0, 0, 1}, bright);
  add_quad(lamp, {-0.25f, 0.25f, -0.25f}, {0, 0, 0.5f}, {0.5f, 0, 0}, dark);
  const Words view = {"--size",        "32x24",         "--spp",     "64",
                      "--look-from",   "0,0.9,4",       "--look-at", "0,0,0",
                      "--transparent", "--cryptomatte", "object"};
  const auto picture_of = [&](const GltfBuilder& gltf, const char* option, const char* value) {
    render(Words{"render", gltf.write_glb(path("a.glb")), "-o", path("a.exr"), option, value} +
           view);
    return read_exr(path("a.exr"));
  };
  const ExrPicture plane = picture_of(lamp, "--catcher-plane", "0");
  const int grey = lamp.push(
      "materials", {{"pbrMetallicRoughness",
                     {{"baseColorFactor", {0.18, 0.18, 0.18, 1}}, {"metallicFactor", 0}}},
                    {"extensions", {{"KHR_materials_specular", {{"specularFactor", 0}}}}}});
  add_quad(lamp, {-20, 0, 20}, {40, 0, 0}, {0, 0, -40}, grey);
  const ExrPicture floor = picture_of(lamp, "--catcher", "2");
  double least = 1;
  for (const char* channel : {"shadow.G", "A", "R"}) {
    for (size_t i = 0; i < plane.channels.at(channel).size(); ++i) {
      const double value = double(plane.channels.at(channel)[i]);
      EXPECT_NEAR(value, double(floor.channels.at(channel)[i]), 0.15) << channel << ", " << i;
      least = std::min(least, value);
    }
  }
  EXPECT_LT(least, 0.6);
}

TEST_F(PlateOptions, APlaneKeepsTheViewAndThePose) {
  GltfBuilder gltf = lamp_scene();
  constexpr int kLamp = 2;  // the index of the lamp's node
  AnimationBuilder(gltf).move(kLamp, "translation", {0, 1}, "VEC3", {0, 0, 0, 0.5f, 0, 0.5f});
  const Words words = {"render",          gltf.write_glb(path("moving.glb")),
                       "--size",          "24x16",
                       "--spp",           "4",
                       "--catcher-plane", "bottom"};
  render(words + Words{"-o", path("a.#.exr"), "--frames", "0-18x9"});
  for (const std::string frame : {"9", "18"}) {
    render(words + Words{"-o", path("b.exr"), "--frame", frame});
    EXPECT_EQ(first_difference(read_exr(path("a." + frame + ".exr")), read_exr(path("b.exr"))), "");
  }
}

TEST_F(PlateOptions, RejectUnsupportedSettings) {
  expect_failure(frame({"--catcher", "flor"}), 2,
                 {"--catcher: no node 'flor'", "nearest", "'floor'"});
  expect_failure(frame({"--holdout", "prop"}), 2, {"--holdout: no node 'prop'", "'props'"});
  expect_failure(frame({"--holdout", "card"}), 2, {"--holdout: no node 'card'", "card\\,"});
  expect_failure(frame({"--holdout", "nothing"}), 2,
                 {"--holdout", "neither the node 'nothing' nor any node below it has a mesh"});
  expect_failure(frame({"--holdout", "floor"}), 2, {"--holdout", "'floor' is already a catcher"});
  expect_failure(frame({"--catcher", std::string(100'000, 'y') + "\n"}), 2, {"--catcher: no node"});
  expect_failure(frame({"--integrator", "ambient_occlusion"}), 2,
                 {"--catcher", "ambient_occlusion", "path or direct"});
  expect_failure(render_words({"--aov", "shadow"}), 2, {"--aov shadow requires --catcher"});
  expect_failure(render_words({"--half", "shadow"}), 2, {"--half shadow requires --aov shadow"});
}

}  // namespace
}  // namespace emberline::test
