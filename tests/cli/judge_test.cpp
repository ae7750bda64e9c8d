// Tests --judge: channels other than R G B decide about samples.

#include <algorithm>
#include <cmath>

#include "cli/command_test.h"

namespace emberline::test {
namespace {

double mean_samples(const ExrPicture& picture) {
  double sum = 0;
  for (const float samples : picture.channels.at("samples")) sum += double(samples);
  return sum / double(picture.channels.at("samples").size());
}

double rms_difference(const ExrPicture& a, const ExrPicture& b, const std::string& channel) {
  double sum = 0;
  const std::vector<float>&x = a.channels.at(channel), &y = b.channels.at(channel);
  for (size_t i = 0; i < x.size(); ++i) sum += double(x[i] - y[i]) * double(x[i] - y[i]);
  return std::sqrt(sum / double(x.size()));
}

class Judge : public CommandTest {
 protected:
  // A floor that catches the shadow of a card below a lamp, which is invisible in R G B.
  void SetUp() override {
    CommandTest::SetUp();
    GltfBuilder gltf = lamp_scene();
    const int card = gltf.push("materials", {{"name", "card"}, {"doubleSided", true}});
    add_quad(gltf, {-0.5f, 0.4f, 0.4f}, {1, 0, 0}, {0, 0, -0.8f}, card);
    for (auto& node : gltf.root["nodes"]) {
      if (node.value("mesh", -1) == 0) node["name"] = "floor";
    }
    gltf.write_glb(path("plate.glb"));
  }
  Words plate(const Words& more) const {
    return Words{"render",   path("plate.glb"), "-o",           path("out.exr"), "--size",
                 "48x36",    "--catcher",       "floor",        "--camera",      "main",
                 "--driver", "adaptive",        "--transparent"} +
           more;
  }
  ExrPicture picture(const Words& words) {
    render(words);
    return read_exr(path("out.exr"));
  }
};

TEST_F(Judge, ShadowsReachTheirThreshold) {
  const ExrPicture truth = picture(plate({"--spp", "16384", "--driver", "bucket", "--seed", "9"}));
  for (const char* driver : {"adaptive", "bucket"}) {
    const Words words = plate({"--noise-threshold", "0.02", "--driver", driver});
    const ExrPicture alone = picture(words);
    const ExrPicture judged = picture(words + Words{"--judge", "RGB,A,shadow:0.01"});
    EXPECT_GT(mean_samples(judged), 1.2 * mean_samples(alone)) << driver;
    EXPECT_LT(rms_difference(judged, truth, "shadow.G"), 0.01) << driver;
    EXPECT_LT(rms_difference(judged, truth, "A"), 0.02) << driver;
    EXPECT_GT(rms_difference(alone, truth, "shadow.G"),
              1.2 * rms_difference(judged, truth, "shadow.G"))
        << driver;
  }
}

TEST_F(Judge, DeliveredStandsForTheLayersOfTheFrame) {
  const Words words = plate({"--noise-threshold", "0.03", "--light-groups"});
  const ExrPicture delivered = picture(words + Words{"--judge", "delivered"});
  EXPECT_EQ(first_difference(delivered, picture(words + Words{"--judge", "RGB,A,shadow,light.*"})),
            "");
  EXPECT_NE(first_difference(delivered, picture(words)), "");
}

TEST_F(Judge, TheDefaultIsTheColour) {
  for (const Words& more : {Words{"--spp", "40"}, Words{"--noise-threshold", "0.03"}}) {
    const Words words = plate(more);
    const ExrPicture plain = picture(words);
    EXPECT_EQ(first_difference(plain, picture(words + Words{"--judge", "RGB"})), "");
    const ExrPicture with_layers = picture(words + Words{"--light-groups", "--aov", "albedo"});
    for (const char* channel : {"R", "G", "B", "A", "samples"}) {
      EXPECT_EQ(rms_difference(plain, with_layers, channel), 0) << channel;
    }
  }
}

TEST_F(Judge, ThreadsAndResumingDoNotChangeTheBits) {
  const Words words = plate(
      {"--noise-threshold", "0.02", "--judge", "delivered", "--light-groups", "--aov", "stop"});
  render(words + Words{"--threads", "1", "-o", path("whole.exr")});
  const ExrPicture whole = read_exr(path("whole.exr"));
  EXPECT_EQ(first_difference(whole, picture(words + Words{"--threads", "3"})), "");
  const Words resumed = words + Words{"--resume", "--resumable", "-o", path("resumed.exr")};
  for (const char* limit : {"0.02", "0.05", "0.1"}) run(resumed + Words{"--time-limit", limit});
  render(resumed);
  EXPECT_EQ(first_difference(whole, read_exr(path("resumed.exr"))), "");
}

TEST_F(Judge, AFrameCanBeExtended) {
  const Words words =
      plate({"--judge", "RGB,shadow:0.01", "--aov", "stop", "--resumable", "--spp", "100000"});
  render(words + Words{"--noise-threshold", "0.05"});
  const double before = mean_samples(read_exr(path("out.exr")));
  render({"extend", path("out.exr"), "--noise-threshold", "0.02"});
  EXPECT_GT(mean_samples(read_exr(path("out.exr"))), before);
}

// The default has no state of its own, and extending can make the default of another list.
TEST_F(Judge, AThresholdOfRgbCanBecomeTheDefault) {
  const Words words = plate({"--judge", "RGB:0.03", "--resumable", "--spp", "100000"});
  render(words + Words{"--noise-threshold", "0.05"});
  render({"extend", path("out.exr"), "--noise-threshold", "0.03"});
}

TEST_F(Judge, PlansJudgeTheSameChannels) {
  const Words more = {"--noise-threshold", "0.05",    "--aov",
                      "albedo,stop",       "--judge", "RGB,albedo,shadow:0.01"};
  const auto planned = [&](const Words& judging) {
    Words words = plate(Words{"--light-groups"} + judging);
    words[0] = "plan";
    words[3] = path("frame.plan");
    render(words);
    return picture(plate(Words{"--light-groups", "--plan", path("frame.plan")} + judging));
  };
  const ExrPicture truth = picture(plate({"--spp", "16384", "--driver", "bucket", "--seed", "9"}));
  EXPECT_LT(rms_difference(planned(more), truth, "shadow.G"), 0.012);
  planned({"--noise-threshold", "0.05", "--judge", "delivered"});
}

TEST_F(Judge, TheFrameNamesTheChannelThatNeededSamples) {
  const Words words =
      plate({"--noise-threshold", "0.1", "--judge", "RGB,shadow:0.005", "--aov", "stop,variance",
             "--heatmap", path("live.exr"), "--heatmap-of", "judge"});
  const ExrPicture judged = picture(words);
  const std::vector<float>& stops = judged.channels.at("stop");
  const auto of_shadow = std::ranges::max_element(stops) - stops.begin();
  EXPECT_EQ(stops[size_t(of_shadow)], 10);  // 2, the threshold, and 8, the second channel
  const std::string pixel = std::to_string(of_shadow % 48) + "," + std::to_string(of_shadow / 48);
  const RunResult explained = run(words + Words{"--explain", pixel});
  EXPECT_NE(explained.out.find(" in shadow"), std::string::npos) << explained.describe();
  EXPECT_NE(explained.out.find("judged by RGB "), std::string::npos) << explained.describe();
  EXPECT_NE(explained.out.find("shadow 0.0"), std::string::npos) << explained.describe();
  EXPECT_NE(explained.out.find("(threshold 0.005)"), std::string::npos) << explained.describe();
  const RunResult read = run({"explain", path("out.exr"), pixel});
  EXPECT_NE(read.out.find("last samples were for shadow"), std::string::npos) << read.describe();
  EXPECT_NE(read.out.find("met --noise-threshold"), std::string::npos) << read.describe();
  render({"heatmap", path("out.exr"), "--of", "judge", "-o", path("judge.exr")});
  const ExrPicture channels = read_exr(path("judge.exr"));
  EXPECT_EQ(channels.channels.at("judge")[size_t(of_shadow)], 1);
  EXPECT_EQ(first_difference(channels, read_exr(path("live.exr"))), "");
  for (const char* quantity : {"judge", "stop"}) {
    render({"heatmap", path("out.exr"), "--of", quantity, "-o", path("map.png")});
  }
  render({"heatmap", path("out.exr"), "--of", "stop", "-o", path("stop.exr")});
  EXPECT_EQ(read_exr(path("stop.exr")).channels.at("stop")[size_t(of_shadow)], 2);
}

TEST_F(Judge, WithoutAThresholdAllChannelsShareTheBudget) {
  const Words words = plate({"--spp", "64"});
  const ExrPicture truth = picture(plate({"--spp", "16384", "--driver", "bucket", "--seed", "9"}));
  const ExrPicture alone = picture(words), judged = picture(words + Words{"--judge", "RGB,shadow"});
  EXPECT_LT(rms_difference(judged, truth, "shadow.G"), rms_difference(alone, truth, "shadow.G"));
}

TEST_F(Judge, WrongListsAreRefused) {
  const std::pair<Words, Words> rows[] = {
      {{"--judge", "albedo"}, {"--judge albedo requires --aov albedo"}},
      {{"--judge", "light.*"}, {"--judge light.* requires --light-groups"}},
      {{"--judge", "RGB,A:0.1"}, {"--judge A:0.1 requires --noise-threshold"}},
      {{"--judge", "RGB,RGB"}, {"--judge: RGB is in the list twice"}},
      {{"--judge", "RGB:0"}, {"--judge: the threshold of RGB must be a number from 1e-06 to"}},
      {{"--judge", "RGB:nan"}, {"--judge: the threshold of RGB must be"}},
      {{"--judge", "samples"}, {"--judge: unknown channel 'samples'"}},
      {{"--judge", "RGB", "--driver", "bucket"}, {"--judge requires --driver adaptive"}},
      {{"--judge", "RGB", "--unbiased"}, {"--judge excludes --unbiased"}},
      {{"--judge", "RGB", "--estimator", "two-stream"},
       {"--judge excludes --estimator two-stream"}},
      {{"--judge", "RGB", "--allocation", "mse"}, {"--judge excludes --allocation"}},
  };
  for (const auto& [more, message] : rows) {
    expect_failure(render_words(Words{"--driver", "adaptive"} + more), 2, message);
  }
}

}  // namespace
}  // namespace emberline::test
