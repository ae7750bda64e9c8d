// Tests `emberline denoise` for sequences, and --across. The result must depend only on the frame
// and on the files of its neighbours. tests/unit/reconstruction/across_test.cpp tests its quality.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "cli/command_test.h"

namespace emberline::test {
namespace {

namespace fs = std::filesystem;

class DenoiseAcross : public CommandTest {
 protected:
  static constexpr const char* kLayers = "denoising,specular_velocity";

  void SetUp() override { render_frames({"--frames", "1-5", "--aov", kLayers}, "shot.####.exr"); }

  // The camera turns by 4 degrees from frame to frame.
  void render_frames(const Words& more, const std::string& name) {
    render(Words{"render", scene(), "--turntable", "90", "--size", "48x40", "--spp", "16", "-o",
                 path(name)} +
           more);
  }
  RunResult denoise(const Words& more) {
    return run(Words{"denoise", path("shot.####.exr")} + more);
  }
  // Denoises all frames to NAME.####.exr.
  std::string denoise_to(const std::string& name, const Words& more) {
    const RunResult result = denoise(Words{"-o", path(name + ".####.exr")} + more);
    EXPECT_EQ(result.exit_code, 0) << result.describe();
    return result.err;
  }
  void expect_same(const std::string& a, const std::string& b) {
    EXPECT_EQ(first_difference(read_exr(path(a)), read_exr(path(b))), "") << a << ' ' << b;
  }
};

std::string combined(const ExrPicture& picture) {
  const auto found = picture.attributes.find("emberline:denoised_with_frames");
  return found == picture.attributes.end() ? "none" : found->second;
}

TEST_F(DenoiseAcross, SameBitsHoweverTheRangeIsSplit) {
  denoise_to("whole", {"--across", "1", "--threads", "2"});
  denoise_to("split", {"--across", "1", "--frames", "4,2", "--threads", "1"});
  denoise_to("split", {"--across", "1", "--frames", "1"});
  denoise_to("split", {"--across", "1", "--frames", "5,3"});
  const char* const expected[] = {"1-2", "1-3", "2-4", "3-5", "4-5"};
  for (int frame = 1; frame <= 5; ++frame) {
    const std::string end = ".000" + std::to_string(frame) + ".exr";
    expect_same("whole" + end, "split" + end);
    EXPECT_EQ(combined(read_exr(path("whole" + end))), expected[frame - 1]);
  }
}

// A tall frame is filtered in bands, whose height depends on the height of the file's tiles.
TEST_F(DenoiseAcross, SameBitsInAnyBands) {
  for (const char* bucket : {"64", "50"}) {
    render_frames({"--frames", "1-3", "--size", "12x1000", "--spp", "2", "--aov", kLayers,
                   "--bucket-size", bucket},
                  "tall" + std::string(bucket) + ".#.exr");
    const RunResult result =
        run({"denoise", path("tall" + std::string(bucket) + ".#.exr"), "--across", "1", "-o",
             path("clean" + std::string(bucket) + ".#.exr")});
    ASSERT_EQ(result.exit_code, 0) << result.describe();
  }
  for (const char* number : {"1", "2", "3"}) {
    expect_same("clean64." + std::string(number) + ".exr",
                "clean50." + std::string(number) + ".exr");
  }
}

// A neighbour that has been denoised still serves with its own samples.
TEST_F(DenoiseAcross, DenoisedNeighboursServe) {
  denoise_to("clean", {"--across", "1"});
  fs::rename(path("clean.0002.exr"), path("shot.0002.exr"));
  denoise_to("again", {"--across", "1", "--frames", "3"});
  expect_same("clean.0003.exr", "again.0003.exr");
}

TEST_F(DenoiseAcross, WithoutItEachFrameIsAlone) {
  denoise_to("clean", {});
  const RunResult alone = run({"denoise", path("shot.0003.exr"), "-o", path("alone.exr")});
  EXPECT_EQ(alone.exit_code, 0);
  expect_same("clean.0003.exr", "alone.exr");
  denoise_to("zero", {"--across", "0"});
  expect_same("zero.0003.exr", "alone.exr");
  EXPECT_EQ(combined(read_exr(path("alone.exr"))), "none");
}

TEST_F(DenoiseAcross, HasLessError) {
  render_frames({"--frames", "3", "--spp", "1024", "--seed", "7"}, "reference.####.exr");
  denoise_to("alone", {"--frames", "3"});
  const std::string log = denoise_to("across", {"--frames", "3", "--across", "2"});
  EXPECT_NE(log.find("frames on average"), std::string::npos) << log;
  const auto error = [&](const std::string& name) {
    const RunResult result =
        run({"compare", path(name), path("reference.0003.exr"), "--json", "--layer", "denoised"});
    return nlohmann::json::parse(result.out)["relmse_trimmed"].get<double>();
  };
  EXPECT_LT(error("across.0003.exr"), error("alone.0003.exr") / 1.2);
}

// Motion leads from one frame to the next, so frames behind a gap are not used.
TEST_F(DenoiseAcross, MissingFramesAreLeftOut) {
  fs::remove(path("shot.0004.exr"));
  const std::string log = denoise_to("clean", {"--across", "2"});
  EXPECT_EQ(combined(read_exr(path("clean.0003.exr"))), "1-3");
  EXPECT_EQ(combined(read_exr(path("clean.0005.exr"))), "5");
  EXPECT_NE(log.find("shot.0003.exr: combined with fewer frames than --across 2 would use: 1-3"),
            std::string::npos)
      << log;
}

TEST_F(DenoiseAcross, FramesThatDoNotFitAreLeftOut) {
  denoise_to("clean", {"--across", "1", "--frames", "5"});
  render_frames({"--frames", "4", "--aov", kLayers, "--size", "40x48"}, "shot.####.exr");
  render_frames({"--frames", "2", "--aov", "denoising"}, "shot.####.exr");
  const std::string log = denoise_to("clean", {"--across", "1", "--frames", "3"});
  EXPECT_EQ(combined(read_exr(path("clean.0003.exr"))), "3");
  EXPECT_NE(log.find("shot.0003.exr: its size or crop differs"), std::string::npos) << log;
  EXPECT_NE(log.find("shot.0003.exr: it has no channels velocity.X, velocity.Y"), std::string::npos)
      << log;
}

TEST_F(DenoiseAcross, LightGroupsAddUp) {
  render_frames({"--frames", "1-3", "--aov", kLayers, "--light-groups", "--env-strength", "0.5",
                 "--sun", "40,10"},
                "shot.####.exr");
  denoise_to("clean", {"--across", "1", "--frames", "2"});
  const ExrPicture clean = read_exr(path("clean.0002.exr"));
  std::vector<float> sum(clean.channels.at("R").size(), 0.0f);
  int groups = 0;
  for (const auto& [name, values] : clean.channels) {
    if (!name.starts_with("denoised.light.") || !name.ends_with(".G")) continue;
    ++groups;
    for (size_t i = 0; i < sum.size(); ++i) sum[i] += values[i];
  }
  EXPECT_GE(groups, 2);
  for (size_t i = 0; i < sum.size(); ++i) {
    const float whole = clean.channels.at("denoised.G")[i];
    ASSERT_NEAR(sum[i], whole, 1e-4f + 1e-4f * whole) << i;
  }
}

// One bad frame does not keep the others from being written, whether its header is damaged or its
// pixels are.
TEST_F(DenoiseAcross, OneBadFrameIsNotTheEnd) {
  const auto bytes = read_bytes(path("shot.0003.exr"));
  for (const size_t size : {size_t(20), bytes.size() / 2}) {
    SCOPED_TRACE(size);
    write("shot.0003.exr", std::string(bytes.begin(), bytes.begin() + std::ptrdiff_t(size)));
    for (const char* across : {"0", "2"}) {
      const RunResult result = denoise({"--across", across, "-o", path("clean.####.exr")});
      EXPECT_EQ(result.exit_code, 3) << result.describe();
      EXPECT_NE(result.err.find("error: " + path("shot.0003.exr")), std::string::npos);
      EXPECT_FALSE(fs::exists(path("clean.0003.exr")));
    }
    EXPECT_EQ(combined(read_exr(path("clean.0001.exr"))), "1-2");
    EXPECT_EQ(combined(read_exr(path("clean.0005.exr"))), "4-5");
  }
  const Words left = {"clean.0001.exr", "clean.0002.exr", "clean.0004.exr", "clean.0005.exr"};
  EXPECT_TRUE(std::ranges::includes(files(), left));
  EXPECT_EQ(files().size(), left.size() + 6);  // five frames and the scene, no scratch file
}

// The range is denoised as `denoise --across` does it, and its pictures are replaced.
TEST_F(DenoiseAcross, RenderedAndDenoisedByOneCommand) {
  denoise_to("clean", {"--across", "1", "-o", path("clean.####.png")});
  const Words frames = {"--denoise", "--across", "1", "-o", path("now.####.png")};
  render_frames(frames + Words{"--frames", "1-5"}, "now.####.exr");
  for (int frame = 1; frame <= 5; ++frame) {
    const std::string number = ".000" + std::to_string(frame);
    expect_same("clean" + number + ".exr", "now" + number + ".exr");
    EXPECT_EQ(read_bytes(path("clean" + number + ".png")),
              read_bytes(path("now" + number + ".png")));
  }
  // Only a missing frame is rendered again, and only its neighbours are denoised again.
  fs::remove(path("now.0001.exr"));
  const auto untouched = fs::last_write_time(path("now.0004.exr"));
  const auto neighbour = fs::last_write_time(path("now.0002.exr"));
  render_frames(frames + Words{"--frames", "1-5", "--skip-existing"}, "now.####.exr");
  for (const char* number : {"1", "2", "3"}) {
    expect_same("clean.000" + std::string(number) + ".exr",
                "now.000" + std::string(number) + ".exr");
  }
  EXPECT_EQ(fs::last_write_time(path("now.0004.exr")), untouched);
  EXPECT_GT(fs::last_write_time(path("now.0002.exr")), neighbour);
}

// A long range shows its first denoised frames early, and an interrupted one has some.
TEST_F(DenoiseAcross, ARangeIsDenoisedWhileItIsRendered) {
  const RunResult result =
      run({"render", scene(), "--turntable", "90", "--size", "48x40", "--spp", "4", "--frames",
           "1-5", "--denoise", "--across", "1", "-o", path("a.####.exr")});
  ASSERT_EQ(result.exit_code, 0) << result.describe();
  std::string order;  // which frame each line is about
  for (size_t at = 0; (at = result.err.find("wrote ", at)) != std::string::npos; ++at) {
    order += result.err[result.err.find(".exr", at) - 1];
  }
  EXPECT_EQ(order, "1213243545") << result.err;
}

// The threshold is that of the combined frames, so single frames may be noisier.
TEST_F(DenoiseAcross, ARangeKeepsTheThresholdAfterCombining) {
  const Words range = {"--frames",          "1-3",  "--driver",  "adaptive",
                       "--noise-threshold", "0.05", "--max-spp", "256"};
  render_frames(range + Words{"--denoise", "--across", "1", "--spp", "256"}, "a.####.exr");
  const ExrPicture picture = read_exr(path("a.0002.exr"));
  const float threshold = std::stof(picture.attributes.at("emberline:noise_threshold"));
  EXPECT_NEAR(threshold, 0.05f * std::sqrt(1.94f), 1e-5f);
  // Saved settings have the user's threshold, not that of single frames.
  render_frames(range + Words{"--denoise", "--across", "1", "--spp", "256", "--save-settings",
                              path("look.json")},
                "s.####.exr");
  EXPECT_FLOAT_EQ(read_json("look.json")["noise-threshold"].get<float>(), 0.05f);
  EXPECT_EQ(read_json("look.json")["denoise"], true);
  EXPECT_FALSE(read_json("look.json").contains("aov"));
  // The same threshold, rendered and denoised by two commands, gives the same bits.
  render_frames(range + Words{"--noise-threshold", std::to_string(threshold), "--spp", "256",
                              "--aov", kLayers},
                "b.####.exr");
  run({"denoise", path("b.####.exr"), "--across", "1", "-o", path("c.####.exr")});
  expect_same("a.0002.exr", "c.0002.exr");
  // With `judge`, it is that of single frames.
  render_frames(range + Words{"--denoise", "--across", "1", "--spp", "256", "--judge", "RGB,A"},
                "d.####.exr");
  EXPECT_EQ(read_exr(path("d.0002.exr")).attributes.at("emberline:noise_threshold"), "0.05");
}

TEST_F(DenoiseAcross, ARangeNeedsWhatItDenoises) {
  const Words render = {"render", scene(), "--turntable", "90",       "--size",
                        "16x16",  "--spp", "1",           "--across", "1"};
  expect_failure(render + Words{"--frames", "1-2", "-o", path("a.##.exr")}, 2,
                 {"--across", "--denoise"});
  expect_failure(render + Words{"--frames", "1-2", "--denoise", "-o", path("a.##.png")}, 2,
                 {"--across", ".exr"});
  expect_failure(render + Words{"--frames", "1-2", "--denoise", "-o", path("f##/a.##.exr")}, 2,
                 {"f##", "--across"});
  expect_failure({"render", scene(), "--denoise", "--across", "1", "-o", path("a.exr")}, 2,
                 {"--across", "--frames"});
}

TEST_F(DenoiseAcross, WritesPictures) {
  denoise_to("clean", {"--across", "1", "-o", path("clean.####.png")});
  denoise_to("alone", {"-o", path("alone.####.png")});
  EXPECT_NE(read_bytes(path("clean.0004.png")), read_bytes(path("alone.0004.png")));
}

TEST_F(DenoiseAcross, RejectsWhatCannotWork) {
  const std::string shot = path("shot.####.exr");
  expect_failure({"denoise", path("shot.0002.exr"), "--across", "1", "-o", path("a.exr")}, 2,
                 {"--across", "####"});
  expect_failure({"denoise", path("shot.0002.exr"), "--frames", "2", "-o", path("a.exr")}, 2,
                 {"--frames", "####"});
  expect_failure({"denoise", shot, "-o", path("a.exr")}, 2, {"a.exr", "####"});
  expect_failure({"denoise", shot, "-o", shot}, 2, {"a frame of the sequence"});
  expect_failure(
      {"denoise", shot, "-o", path("shot.9.exr"), "-o", path("shot.0005.exr"), "--frames", "3"}, 2,
      {"a frame of the sequence"});
  expect_failure({"denoise", shot, "--across", "5", "-o", path("a.####.exr")}, 2,
                 {"--across", "0 to 4"});
  expect_failure({"denoise", shot, "--frames", "8", "-o", path("a.####.exr")}, 3,
                 {"shot.0008.exr"});
  expect_failure({"denoise", path("none.####.exr"), "--across", "1", "-o", path("a.####.exr")}, 3,
                 {"none.####.exr"});
  render_frames({"--frames", "7", "--aov", "denoising"}, "still.####.exr");
  expect_failure({"denoise", path("still.####.exr"), "--across", "1", "-o", path("a.####.exr")}, 3,
                 {"velocity.X", "--aov denoising,velocity"});
  expect_failure({"denoise", shot, "--frames", "3", "-o", path("none/a.####.exr")}, 1, {"none"});
}

// A neighbour that needs too much memory is not left out, since the result would be another.
TEST_F(DenoiseAcross, NeighboursCountAgainstTheMemoryLimit) {
  const Words limited = {"--frames", "3", "--memory-limit", "4300K"};
  denoise_to("a", limited);
  for (const char* limit : {"4300K", "3M"}) {
    expect_failure(Words{"denoise", path("shot.####.exr"), "--across", "2", "--frames", "3",
                         "--memory-limit", limit, "-o", path("b.####.exr")},
                   3, {"shot.000", "--memory-limit"});
  }
}

}  // namespace
}  // namespace emberline::test
