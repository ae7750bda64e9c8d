// Tests --aov direct,indirect,…: the layers by light path in a file, and how merge, resume and
// extend treat these layers.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "cli/command_test.h"

namespace emberline::test {
namespace {

const Words kLayers = {"direct",       "indirect",   "emission",
                       "transmission", "reflection", "environment"};

class PathLayersOption : public CommandTest {
 protected:
  // The scene has the lamp, a pane and a mirror in front of a grey sky.
  void SetUp() override {
    GltfBuilder gltf = lamp_scene();
    const int pane =
        gltf.push("materials",
                  {{"name", "pane"},
                   {"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 0}}},
                   {"extensions", {{"KHR_materials_transmission", {{"transmissionFactor", 1}}}}}});
    const int mirror = gltf.push(
        "materials", {{"name", "mirror"},
                      {"pbrMetallicRoughness", {{"metallicFactor", 1}, {"roughnessFactor", 0.1}}}});
    gltf.root["extensionsUsed"] = {"KHR_materials_transmission"};
    add_quad(gltf, {-1.5f, 0.2f, 0.5f}, {1.2f, 0, 0}, {0, 1.2f, 0}, pane);
    add_quad(gltf, {0.4f, 0.1f, 0.2f}, {0.7f, 0, 0}, {0, 0.7f, 0}, mirror);
    gltf.write_glb(path("scene.glb"));
    write_floats(path("grey.exr"), 8, 4, 3, std::vector<float>(8 * 4 * 3, 0.25f));
  }
  Words frame(const Words& more) {
    return Words{"render",   path("scene.glb"),
                 "-o",       path("out.exr"),
                 "--env",    path("grey.exr"),
                 "--size",   "24x18",
                 "--aov",    "direct,indirect,emission,transmission,reflection,environment",
                 "--driver", "bucket"} +
           more;
  }
  ExrPicture picture(const Words& more) {
    render(frame(more));
    return read_exr(path("out.exr"));
  }
};

void expect_sums(const ExrPicture& picture) {
  for (const char* channel : {"R", "G", "B"}) {
    const std::vector<float>& whole = picture.channels.at(channel);
    for (size_t i = 0; i < whole.size(); ++i) {
      float sum = 0.0f;
      for (const std::string& layer : kLayers) {
        sum += picture.channels.at(layer + "." + channel)[i];
      }
      ASSERT_NEAR(sum, whole[i], 1e-5f * whole[i]) << channel << ", pixel " << i;
    }
  }
}

TEST_F(PathLayersOption, AddUpAndGoThroughCheckpoints) {
  const Words buckets = {"--bucket-size", "8"};
  const ExrPicture whole = picture(buckets + Words{"--spp", "8"});
  expect_sums(whole);
  for (const std::string& layer : kLayers) {
    float most = 0.0f;
    for (const float g : whole.channels.at(layer + ".G")) most = std::max(most, g);
    EXPECT_GT(most, 0.0f) << layer;
  }

  for (const char* part : {"1/2", "2/2"}) {
    render(frame(buckets + Words{"--spp", "8", "--part", part}));
  }
  render({"merge", "-o", path("merged.exr"), path("out.exr.part-1-of-2.checkpoint"),
          path("out.exr.part-2-of-2.checkpoint")});
  EXPECT_EQ(first_difference(whole, read_exr(path("merged.exr"))), "");

  for (const char* range : {"0-3", "3-8"}) render(frame(buckets + Words{"--sample-range", range}));
  render({"merge", "-o", path("ranges.exr"), path("out.exr.samples-0-3.checkpoint"),
          path("out.exr.samples-3-8.checkpoint")});
  const ExrPicture ranges = read_exr(path("ranges.exr"));
  expect_sums(ranges);
  for (const auto& [name, values] : whole.channels) {
    for (size_t i = 0; i < values.size(); ++i) {
      ASSERT_NEAR(ranges.channels.at(name)[i], values[i], 2e-6f * std::abs(values[i])) << name;
    }
  }

  render(frame(buckets + Words{"--spp", "4", "--resumable"}));
  render({"extend", path("out.exr"), "--spp", "8", "-o", path("extended.exr")});
  EXPECT_EQ(first_difference(whole, read_exr(path("extended.exr"))), "");
}

TEST_F(PathLayersOption, LightpathIsAllSixLayers) {
  const Words six = {"--aov", "direct,indirect,emission,transmission,reflection,environment,N,Z"};
  render(render_words(six));
  const ExrPicture expected = read_exr(path("out.exr"));
  render(render_words({"--aov", "lightpath,normal,depth", "--resumable"}));
  EXPECT_EQ(first_difference(expected, read_exr(path("out.exr"))), "");
  // Checkpoints and rules know only the names of the channels. They do not know "lightpath".
  render(render_words(six + Words{"--resumable", "--resume"}));
  expect_failure(render_words({"--aov", "lightpath", "--integrator", "normal"}), 2,
                 {"--aov direct requires --integrator"});
  expect_failure(render_words({"--aov", "lightpaths"}), 2, {"did you mean 'lightpath'"});
}

TEST_F(PathLayersOption, AddUpInEveryFrame) {
  expect_sums(picture({"--spp", "32", "--driver", "adaptive", "--unbiased"}));
  expect_sums(picture({"--spp", "16", "--light-groups", "--denoise"}));
  // In a stopped frame, pixels without samples get the values of their neighbours.
  render(
      frame({"--driver", "bisection", "--size", "400x300", "--spp", "1", "--time-limit", "0.001"}));
  const ExrPicture stopped = read_exr(path("out.exr"));
  const std::vector<float>& samples = stopped.channels.at("samples");
  ASSERT_NE(std::ranges::find(samples, 0.0f), samples.end()) << "the frame was finished";
  expect_sums(stopped);
}

TEST_F(PathLayersOption, AreRefusedForIntegratorsWithoutPaths) {
  expect_failure(frame({"--integrator", "normal"}), 2,
                 {"--aov direct", "normal", "path or direct"});
  expect_failure(render_words({"--half", "direct"}), 2, {"--half direct requires --aov direct"});
}

}  // namespace
}  // namespace emberline::test
