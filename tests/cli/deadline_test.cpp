// Tests --time-budget, and frames that are repeated from the samples of another frame. That frames
// end on time is measured by tests/bench/deadlines.py, because it depends on the machine.

#include <algorithm>

#include "cli/command_test.h"
#include "renderer/film/pixel_stop.h"

namespace emberline::test {
namespace {

class Deadline : public CommandTest {
 protected:
  Words frame(const std::string& output, const Words& more) {
    return Words{"render", scene(), "-o", path(output), "--size", "40x24", "--bucket-size", "8"} +
           more;
  }
  ExrPicture picture(const Words& words) {
    render(words);
    return read_exr(path("out.exr"));
  }
  static void expect_equal_pixels(const ExrPicture& a, const ExrPicture& b) {
    for (const char* channel : {"R", "G", "B", "A", "samples"}) {
      EXPECT_EQ(a.channels.at(channel), b.channels.at(channel)) << channel;
    }
  }
};

TEST_F(Deadline, EveryDriverFillsTheFrameAndTheFrameCanBeRepeated) {
  for (const Words& driver :
       {Words{"--driver", "bucket"}, Words{"--driver", "bisection"}, Words{"--driver", "adaptive"},
        Words{"--driver", "adaptive", "--noise-threshold", "0.0001", "--denoise"}}) {
    const ExrPicture timed =
        picture(frame("out.exr", driver + Words{"--time-budget", "0.3", "--aov", "stop"}));
    const std::vector<float>& samples = timed.channels.at("samples");
    EXPECT_GE(*std::ranges::min_element(samples), 1) << driver.back();
    for (const float stop : timed.channels.at("stop")) {
      if (driver.back() == "--denoise" && stop == float(PixelStop::kThreshold)) continue;
      ASSERT_EQ(stop, float(PixelStop::kTimeBudget)) << driver.back();
    }
    const Words denoised = driver.back() == "--denoise" ? Words{"--denoise"} : Words{};
    render(frame("again.exr", Words{"--driver", "adaptive", "--plan", path("out.exr")} + denoised));
    expect_equal_pixels(timed, read_exr(path("again.exr")));
  }
}

TEST_F(Deadline, BucketsGetASampleEvenWithoutTime) {
  const Words words = frame("out.exr", {"--size", "640x360"}), budget = {"--time-budget", "0.001"};
  const ExrPicture timed = picture(words + budget);
  expect_equal_pixels(timed, picture(words + Words{"--spp", "1"}));
  // Both halves of a denoised frame need samples.
  const ExrPicture denoised = picture(frame("out.exr", budget + Words{"--denoise"}));
  EXPECT_GE(*std::ranges::min_element(denoised.channels.at("samples")), 16);
}

TEST_F(Deadline, StoppedFramesResume) {
  for (const char* driver : {"bucket", "bisection", "adaptive"}) {
    const std::string name = std::string(driver) + ".exr";
    const Words words =
        frame(name, {"--driver", driver, "--time-budget", "0.4", "--resume", "--resumable"});
    for (const char* limit : {"0.05", "0.2"}) run(words + Words{"--time-limit", limit});
    render(words);
    const ExrPicture resumed = read_exr(path(name));
    EXPECT_GE(*std::ranges::min_element(resumed.channels.at("samples")), 1);
    render(frame("again.exr", {"--driver", "adaptive", "--plan", path(name)}));
    expect_equal_pixels(resumed, read_exr(path("again.exr")));
    expect_failure({"extend", path(name), "--spp", "4000"}, 3, {"--time-budget"});
  }
}

TEST_F(Deadline, ReportsNameTheBudget) {
  render(frame("out.exr", {"--time-budget", "0.1", "--report", path("r.json")}));
  EXPECT_EQ(read_json("r.json")["settings"]["time_budget_s"], 0.1);
  const RunResult info = run({"info", path("out.exr")});
  EXPECT_NE(info.out.find("--time-budget 0.1"), std::string::npos) << info.describe();
}

TEST_F(Deadline, OtherLimitsAreRefused) {
  const std::pair<Words, Words> rows[] = {
      {{"--spp", "4"}, {"--time-budget excludes --spp"}},
      {{"--part", "1/2"}, {"--time-budget excludes --part"}},
      {{"--noise-threshold", "0.1"}, {"--time-budget excludes --driver bucket"}},
      {{"--driver", "adaptive", "--unbiased"}, {"--time-budget excludes --unbiased"}},
      {{"--sampler", "stratified"}, {"--time-budget requires --sampler"}},
  };
  for (const auto& [more, message] : rows) {
    expect_failure(frame("out.exr", Words{"--time-budget", "1"} + more), 2, message);
  }
}

TEST_F(Deadline, PicturesOfOtherSamplesAreNoPlans) {
  picture(frame("out.exr", {"--spp", "3", "--noise-threshold", "0.1"}));
  const Words words = {"--driver", "adaptive", "--plan", path("out.exr")};
  expect_failure(frame("o.exr", words + Words{"--seed", "4"}), 3, {"out.exr", "--seed 0 (now 4)"});
  expect_failure(frame("o.exr", words + Words{"--max-depth", "2"}), 3, {"out.exr", "--max-depth"});
  expect_failure(frame("o.exr", words + Words{"--denoise"}), 3, {"out.exr", "denoised"});
  expect_failure(frame("o.exr", words + Words{"--sampler", "independent"}), 3,
                 {"out.exr", "--sampler"});
  expect_failure(frame("o.exr", words + Words{"--catcher", "0"}), 3, {"out.exr", "--catcher"});
  expect_failure(frame("o.exr", words + Words{"--size", "41x24"}), 3, {"out.exr", "--size"});
  render({"heatmap", path("out.exr"), "-o", path("samples.exr")});
  expect_failure(frame("o.exr", {"--driver", "adaptive", "--plan", path("samples.exr")}), 3,
                 {"samples.exr"});
  render(frame("cut.exr", {"--driver", "bucket", "--spp", "60000", "--time-limit", "0.1"}));
  expect_failure(frame("o.exr", {"--driver", "adaptive", "--plan", path("cut.exr")}), 3,
                 {"cut.exr", "invalid number of samples"});
}

}  // namespace
}  // namespace emberline::test
