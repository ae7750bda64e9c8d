// Tests --animation, --time and --frame, which render the scene in a pose of its animations.
#include "cli/command_test.h"

#include <fstream>
#include <nlohmann/json.hpp>
#include "support/animated_gltf.h"

namespace emberline::test {
namespace {

class AnimationOption : public CommandTest {
 protected:
  // lamp_scene() with two animations. The lamp moves down in "sink" and becomes dimmer in "fade".
  static GltfBuilder moving() {
    GltfBuilder gltf = lamp_scene();
    const int lamp = 2;
    AnimationBuilder(gltf, "sink").move(lamp, "translation", {0, 2}, "VEC3", {0, 0, 0, 0, -0.5, 0});
    AnimationBuilder(gltf, "fade")
        .point("/materials/1/emissiveFactor", {0, 1}, "VEC3", {1, 1, 1, 0.5, 0.5, 0.5});
    return gltf;
  }
  ExrPicture picture(const Words& more = {}) {
    render(render_words(Words{"--spp", "4"} + more));
    return read_exr(path("out.exr"));
  }
  void use(const GltfBuilder& gltf) { gltf.write_glb(path("scene.glb")); }
  void SetUp() override {
    scene();
    use(moving());
  }
};

// Returns the largest relative difference in radiance.
double largest_difference(const ExrPicture& a, const ExrPicture& b) {
  double largest = 0;
  for (const char* channel : {"R", "G", "B"}) {
    const std::vector<float>&x = a.channels.at(channel), &y = b.channels.at(channel);
    for (size_t i = 0; i < x.size(); ++i) {
      largest =
          std::max(largest, std::abs(double(x[i]) - double(y[i])) / std::max(1e-3, double(x[i])));
    }
  }
  return largest;
}

TEST_F(AnimationOption, AShutterAtRestSaysWhatToAdd) {
  const Words shutter = {"--shutter", "0,0.5"};
  const std::string hint =
      "has no effect while the animation is not played; add --animation or --time";
  EXPECT_NE(render(render_words(shutter)).err.find(hint), std::string::npos);
  EXPECT_EQ(render(render_words(shutter + Words{"--time", "1"})).err.find(hint), std::string::npos);
}

// An animated object is an instance, so its transform is not baked into its vertices. Therefore the
// pictures differ by rounding from those of a file without animations.
TEST_F(AnimationOption, EqualsAFileInThatPose) {
  const ExrPicture at_rest = picture();
  const ExrPicture sunk = picture({"--time", "1"});
  EXPECT_NE(sunk.channels, at_rest.channels);
  const Words same_noise = {"--static-noise", "--frame"};
  EXPECT_EQ(picture(same_noise + Words{"12", "--fps", "12"}).channels, sunk.channels);
  EXPECT_EQ(picture(same_noise + Words{"24", "--animation", "sink"}).channels, sunk.channels);
  EXPECT_NE(picture({"--animation", "sink", "--frame", "24"}).channels, sunk.channels);
  EXPECT_EQ(picture({"--animation", "sink"}).channels, at_rest.channels);
  const ExrPicture faded = picture({"--animation", "1", "--time", "1"});
  const ExrPicture both = picture({"--animation", "all", "--time", "1"});

  GltfBuilder posed = lamp_scene();
  use(posed);
  EXPECT_EQ(picture().channels, at_rest.channels);
  posed.root["nodes"][2]["translation"] = {0, -0.25, 0};
  use(posed);
  EXPECT_LT(largest_difference(picture(), sunk), 1e-4);
  posed.root["materials"][1]["emissiveFactor"] = {0.5, 0.5, 0.5};
  use(posed);
  EXPECT_LT(largest_difference(picture(), both), 1e-4);
  posed.root["nodes"][2].erase("translation");
  use(posed);
  EXPECT_EQ(picture().channels, faded.channels);
}

// The lamp sinks by a quarter of a unit per second, which determines its velocity in pixels per
// frame. The shutter must not affect the velocity. Recording the velocity must not change the
// picture.
TEST_F(AnimationOption, VelocityDoesNotChangeThePicture) {
  const auto fastest = [](const ExrPicture& exr) {
    const std::vector<float>& y = exr.channels.at("velocity.Y");
    return double(*std::ranges::min_element(y));
  };
  double of_a_frame = 0;
  for (const Words& shutter : {Words{}, Words{"--shutter", "0,0.5"}}) {
    const Words when = Words{"--animation", "sink",    "--time",    "1",
                             "--look-from", "0,0.2,3", "--look-at", "0,1,0"} +
                       shutter;
    const ExrPicture without = picture(when);
    ExrPicture with = picture(when + Words{"--aov", "velocity"});
    const ExrPicture slower = picture(when + Words{"--aov", "velocity", "--fps", "12"});
    if (shutter.empty()) of_a_frame = fastest(with);
    EXPECT_LT(of_a_frame, -0.01);
    EXPECT_NEAR(fastest(with) / of_a_frame, 1, 0.05);
    EXPECT_NEAR(fastest(slower) / of_a_frame, 2, 0.1);
    with.channels.erase("velocity.X");
    with.channels.erase("velocity.Y");
    EXPECT_EQ(with.channels, without.channels);
  }
  // An edit can also set the shutter.
  const Words view = {"--look-from", "0,0.2,3", "--look-at", "0,1,0", "--aov", "velocity"};
  std::ofstream(path("shutter.json"))
      << R"({"emberline_edits": 1, "animation": {"name": "sink", "time": 1, "shutter_open": 0,
             "shutter_close": 0.5}})";
  const Words shutter = {"--animation", "sink", "--time", "1", "--shutter", "0,0.5"};
  for (const Words& turn : {Words{}, Words{"--turntable", "2/36"}}) {
    EXPECT_EQ(picture(view + turn + Words{"--edits", path("shutter.json")}).channels,
              picture(view + turn + shutter).channels);
  }
  // In a scene at rest, velocities are zero unless a turntable moves the camera.
  const ExrPicture at_rest = picture({"--aov", "velocity"});
  EXPECT_EQ(at_rest.channels.at("velocity.X"), std::vector<float>(256, 0.0f));
  const ExrPicture turning =
      picture({"--aov", "velocity", "--turntable", "1/36", "--static-noise"});
  const std::vector<float>& x = turning.channels.at("velocity.X");
  EXPECT_GT(*std::ranges::max_element(x) - *std::ranges::min_element(x), 0.5f);
  EXPECT_EQ(turning.channels.at("G"), at_rest.channels.at("G"));
}

TEST_F(AnimationOption, ErrorListsTheAnimations) {
  for (const char* wrong : {"swim", "2", "-1"}) {
    expect_failure(
        render_words({"--animation", wrong}), 2,
        {"--animation: no animation '" + std::string(wrong) + "'", "0 'sink', 1 'fade'"});
  }
  const RunResult result = run({"info", path("scene.glb")});
  EXPECT_NE(result.out.find("animation 0 'sink' 2 s, 1 nodes\n"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("animation 1 'fade' 1 s, 1 other values\n"), std::string::npos);
  EXPECT_NE(result.out.find("not played: 2 animations; choose one with --animation\n"),
            std::string::npos);
  EXPECT_EQ(result.out.find("ignored"), std::string::npos);
  const RunResult posed = run({"info", path("scene.glb"), "--time", "2"});
  EXPECT_EQ(posed.out.find("not played"), std::string::npos) << posed.out;
  const RunResult json = run({"info", path("scene.glb"), "--json", "--time", "2"});
  ASSERT_EQ(json.exit_code, 0) << json.describe();
  const nlohmann::json parsed = nlohmann::json::parse(json.out);
  EXPECT_EQ(parsed["animations"][0]["name"], "sink");
  EXPECT_EQ(parsed["animations"][0]["duration_s"], 2.0);
  EXPECT_EQ(parsed["animations"][1]["pointers"], 1);
}

TEST_F(AnimationOption, BrokenAnimationIsRefusedOnlyIfChosen) {
  GltfBuilder broken = moving();
  broken.root["animations"][0]["samplers"][0]["interpolation"] = "CURLY";
  use(broken);
  EXPECT_NE(render(render_words()).err.find("unknown interpolation"), std::string::npos);
  const RunResult info = run({"info", path("scene.glb")});
  EXPECT_NE(info.out.find("animation 0 '' 0 s; unusable: "), std::string::npos) << info.out;
  std::filesystem::remove(path("out.exr"));
  expect_failure(render_words({"--animation", "0"}), 3,
                 {"scene.glb#/animations/0/samplers/0/interpolation", "CURLY"});
}

TEST_F(AnimationOption, HiddenSceneShowsTheEnvironment) {
  GltfBuilder gltf;
  gltf.add_triangle();
  gltf.root["nodes"][0]["extensions"]["KHR_node_visibility"]["visible"] = true;
  AnimationBuilder(gltf).point<uint8_t>("/nodes/0/extensions/KHR_node_visibility/visible", {0, 1},
                                        "BOOL", {0, 1}, "STEP");
  use(gltf);
  const RunResult hidden =
      render(render_words({"--spp", "4", "--driver", "adaptive", "--time", "0"}));
  EXPECT_NE(hidden.err.find("the animation hides all objects at this time"), std::string::npos);
  // The environment is plain white, as in frames that show the triangle, so that a sequence does
  // not flash.
  const std::vector<float> red = read_exr(path("out.exr")).channels.at("R");
  EXPECT_EQ(red, std::vector<float>(red.size(), 1.0f));
  // The triangle appears after a quarter of the shutter. A replay prints the time of its sample.
  const Words shutter = {"--time", "0.75", "--fps", "1", "--shutter", "0,1"};
  EXPECT_EQ(
      render(render_words(shutter + Words{"--report", path("report.json")})).err.find("hides"),
      std::string::npos);
  EXPECT_NE(read_json("report.json")["features"].dump().find("visibility (1 instances"),
            std::string::npos);
  const RunResult replay = run(render_words(shutter + Words{"--replay", "1,2,3"}));
  EXPECT_NE(replay.out.find("\ntime 0."), std::string::npos) << replay.describe();
}

// A frame in which no object is visible must not end the sequence. It must show the environment.
TEST_F(AnimationOption, VanishedSceneShowsTheEnvironment) {
  GltfBuilder gltf;
  gltf.add_triangle();
  AnimationBuilder(gltf).move(0, "scale", {0, 1}, "VEC3", {1, 1, 1, 0, 0, 0}, "STEP");
  use(gltf);
  const Words frames = {"render", path("scene.glb"), "--size", "8x8",           "--spp",
                        "4",      "--frames",        "0-1",    "--fps",         "1",
                        "--sun",  "60,30",           "-o",     path("f.#.exr"), "--animation",
                        "0"};
  const RunResult result = run(frames);
  ASSERT_EQ(result.exit_code, 0) << result.describe();
  EXPECT_NE(result.err.find("1 objects scaled to zero"), std::string::npos) << result.describe();
  // Only the first frame shows the triangle. The second must show the sky, as an empty scene does.
  use(GltfBuilder());
  const RunResult empty = run({"render", path("scene.glb"), "--size", "8x8", "--spp", "4", "--sun",
                               "60,30", "-o", path("empty.exr")});
  ASSERT_EQ(empty.exit_code, 0) << empty.describe();
  EXPECT_NE(empty.err.find("nothing is visible"), std::string::npos) << empty.describe();
  for (const std::string& file : {path("f.1.exr"), path("empty.exr")}) {
    const ExrPicture sky = read_exr(file);
    EXPECT_EQ(sky.channels.at("A"), std::vector<float>(64, 1.0f));
    EXPECT_GT(*std::ranges::min_element(sky.channels.at("B")), 0.0f);
  }
  EXPECT_NE(read_exr(path("f.0.exr")).channels.at("B"), read_exr(path("f.1.exr")).channels.at("B"));
}

}  // namespace
}  // namespace emberline::test
