// Tests --light-groups, which writes the contribution of each light as an EXR layer.
#include <nlohmann/json.hpp>

#include "cli/command_test.h"

namespace emberline::test {
namespace {

class LightGroupsOption : public CommandTest {
 protected:
  // The scene has the lamp, a second emissive material with the same name, and a black one. There
  // is also a file with a grey sky.
  void SetUp() override {
    GltfBuilder gltf = lamp_scene();
    const int second =
        gltf.push("materials", {{"name", "lamp"}, {"emissiveFactor", {0.1, 0.2, 0.9}}});
    add_quad(gltf, {-1.5f, 0.2f, -1}, {0.7f, 0, 0}, {0, 0.7f, 0}, second);
    gltf.push("materials", {{"name", "kept dark"}, {"emissiveFactor", {0, 0, 0}}});
    gltf.write_glb(path("scene.glb"));
    write_floats(path("grey.exr"), 8, 4, 3, std::vector<float>(8 * 4 * 3, 0.25f));
  }
  Words words(const Words& more) {
    return render_words(Words{"--env", path("grey.exr"), "--spp", "8"} + more);
  }
  ExrPicture picture(const Words& more) {
    render(words(more));
    return read_exr(path("out.exr"));
  }
};

// Expects that the layers add up to the picture in every pixel.
void expect_sums(const ExrPicture& picture, const Words& layers) {
  for (const char* channel : {"R", "G", "B"}) {
    const std::vector<float>& whole = picture.channels.at(channel);
    for (size_t i = 0; i < whole.size(); ++i) {
      float sum = 0.0f;
      for (const std::string& layer : layers) {
        sum += picture.channels.at("light." + layer + "." + channel)[i];
      }
      ASSERT_NEAR(sum, whole[i], 1e-5f * whole[i]) << channel << ", pixel " << i;
    }
  }
}

TEST_F(LightGroupsOption, AreLayersThatAddUp) {
  const Words layers = {"lamp", "lamp_2", "environment"};
  const ExrPicture plain = picture({"--aov", "albedo"});
  for (const char* driver : {"bucket", "bisection"}) {
    const ExrPicture seen =
        picture({"--aov", "albedo", "--light-groups", "--driver", driver, "--bucket-size", "7"});
    ASSERT_EQ(seen.channels.size(), plain.channels.size() + 9) << driver;
    expect_sums(seen, layers);
    for (const auto& [name, values] : plain.channels) {
      EXPECT_EQ(seen.channels.at(name), values) << driver << ", " << name;
    }
  }
}

// The header, the report and the layers must say how much was clamped, and from which light.
TEST_F(LightGroupsOption, ReportTheClampedLight) {
  const Words clamped = {"--light-groups", "--aov", "clamped", "--clamp-indirect", "0.05"};
  const ExrPicture seen = picture(clamped + Words{"--report", path("report.json")});
  expect_sums(seen, {"lamp", "lamp_2", "environment"});
  const nlohmann::json report = read_json("report.json")["clamped"];
  EXPECT_FLOAT_EQ(report["limit"].get<float>(), 0.05f);
  const double share = report["share"];
  EXPECT_GT(share, 0.0);
  EXPECT_NEAR(std::stod(seen.attributes.at("emberline:clamped")), share, 1e-3 * share);
  EXPECT_EQ(seen.attributes.at("emberline:clamp_indirect"), "0.05");
  const std::vector<float>& green = seen.channels.at("clamped.G");
  double sum = 0;
  for (const float g : green) sum += double(g);
  const double mean = report["mean"][1];
  EXPECT_NEAR(sum / double(green.size()), mean, 1e-4 * mean);
  double groups = 0;
  for (const auto& group : report["groups"]) groups += group[1].get<double>();
  EXPECT_NEAR(groups, mean, 1e-5 * mean);
  EXPECT_EQ(report["groups"].size(), 3u);

  render(words({"--report", path("report.json")}));
  EXPECT_TRUE(read_json("report.json")["clamped"].is_null());
}

TEST_F(LightGroupsOption, FollowTheEdits) {
  write("shot.json", nlohmann::json({{"emberline_edits", 1},
                                     {"lights",
                                      {{{"kind", "material"}, {"index", 1}, {"on", false}},
                                       {{"kind", "environment"}, {"intensity", 2}}}}})
                         .dump());
  const ExrPicture seen = picture({"--light-groups", "--edits", path("shot.json")});
  EXPECT_EQ(seen.channels.size(), 5u + 6);
  expect_sums(seen, {"lamp", "environment"});
  // This pixel shows the background, to which only the sky contributes.
  EXPECT_EQ(seen.at("light.environment.G", 8, 0), seen.at("G", 8, 0));
  EXPECT_EQ(seen.at("light.lamp.G", 8, 0), 0.0f);
}

// In a stopped progressive frame, pixels without samples get the values of their neighbours. This
// must hold for the picture and for its layers.
TEST_F(LightGroupsOption, AddUpInAStoppedFrame) {
  render(words({"--light-groups", "--driver", "bisection", "--size", "400x300", "--spp", "1",
                "--time-limit", "0.001"}));
  const ExrPicture stopped = read_exr(path("out.exr"));
  const std::vector<float>& samples = stopped.channels.at("samples");
  ASSERT_NE(std::ranges::find(samples, 0.0f), samples.end()) << "the frame was finished";
  expect_sums(stopped, {"lamp", "lamp_2", "environment"});
}

TEST_F(LightGroupsOption, IsRefusedForIntegratorsWithoutLights) {
  expect_failure(words({"--light-groups", "--integrator", "normal"}), 2,
                 {"--light-groups", "normal", "path or direct"});
  expect_failure(words({"--light-groups", "--driver", "adaptive", "--unbiased"}), 2,
                 {"--light-groups", "--unbiased"});
  expect_failure({"render", scene(), "-o", path("out.png"), "--light-groups"}, 2,
                 {"--light-groups", ".exr"});
}

}  // namespace
}  // namespace emberline::test
