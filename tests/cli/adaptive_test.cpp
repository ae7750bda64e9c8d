// Tests adaptive sampling on the command line: refused options, the output after a stop or a limit,
// and the report.

#include <algorithm>
#include <csignal>
#include <nlohmann/json.hpp>
#include <numeric>
#include <tuple>

#include "cli/command_test.h"

namespace emberline::test {
namespace {

class Adaptive : public CommandTest {
 protected:
  Words adaptive(const Words& more = {}) {
    return render_words(Words{"--driver", "adaptive", "--spp", "16"} + more);
  }
  // Expects that the total, minimum and maximum of samples in the report match the samples channel.
  void expect_true_counts() {
    const ExrPicture picture = read_exr(path("out.exr"));
    const std::vector<float>& samples = picture.channels.at("samples");
    const nlohmann::json json = read_json("r.json");
    const double sum = std::accumulate(samples.begin(), samples.end(), 0.0);
    EXPECT_GT(sum, 0.0);
    EXPECT_EQ(json["samples"]["total"], uint64_t(sum));
    EXPECT_EQ(json["samples"]["min"], uint64_t(*std::ranges::min_element(samples)));
    EXPECT_EQ(json["samples"]["max"], uint64_t(*std::ranges::max_element(samples)));
    EXPECT_EQ(json["rays"]["camera"], uint64_t(sum));
    for (const char* channel : {"R", "G", "B", "A"}) {
      for (const float value : picture.channels.at(channel)) ASSERT_TRUE(std::isfinite(value));
    }
  }
};

TEST_F(Adaptive, RejectsContradictoryLimits) {
  expect_failure(adaptive({"--min-spp", "9", "--max-spp", "8"}), 2,
                 {"--min-spp 9", "--max-spp 8", "valid is 1 to 8"});
  expect_failure(adaptive({"--min-spp", "17"}), 2, {"--min-spp 17", "--spp 16", "1 to 16"});
  // Equal --min-spp and --max-spp give uniform sampling.
  render(adaptive({"--min-spp", "16", "--max-spp", "16", "--report", path("r.json")}));
  expect_true_counts();
  EXPECT_EQ(read_json("r.json")["samples"]["max"], 16);
}

TEST_F(Adaptive, SamplersOfAFixedCountAreRefused) {
  for (const char* name : {"stratified", "blue_noise"}) {
    expect_failure(adaptive({"--sampler", name}), 2,
                   {"--sampler", name, "it supports", "sobol", "independent"});
    expect_failure(render_words({"--sampler", name, "--noise-threshold", "0.1"}), 2,
                   {"--sampler", name, "it supports"});
  }
}

TEST_F(Adaptive, AnEstimatorOfTwoStreamsNeedsTwo) {
  for (const char* name : {"two-stream", "kajiya", "dammertz"}) {
    expect_failure(adaptive({"--estimator", name, "--streams", "1"}), 2,
                   {"--streams 1", name, "set --streams to 2"});
  }
  for (const char* name : {"contrast", "painter-sloan", "chi-square"}) {
    for (const char* streams : {"1", "2"}) {
      render(adaptive({"--estimator", name, "--streams", streams}));
    }
  }
}

TEST_F(Adaptive, RejectsOptionsWithoutEffectOnUniformSampling) {
  const std::vector<Words> options = {{"--min-spp", "4"},
                                      {"--max-spp", "4"},
                                      {"--estimator", "kajiya"},
                                      {"--allocation", "relmse"},
                                      {"--unbiased"}};
  for (const Words& option : options) {
    for (const char* driver : {"bucket", "bisection"}) {
      expect_failure(render_words(Words{"--driver", driver} + option), 2,
                     {option[0], driver, "--driver adaptive"});
    }
  }
  expect_failure(render_words({"--driver", "bisection", "--noise-threshold", "0.1"}), 2,
                 {"--noise-threshold", "bisection", "--driver bucket or adaptive"});
  expect_failure(adaptive({"--estimator", "kajiya", "--allocation", "mse"}), 2,
                 {"--allocation", "kajiya", "two-stream"});
}

TEST_F(Adaptive, UnbiasedSamplesEveryPixelInEveryRound) {
  expect_failure(adaptive({"--unbiased", "--estimator", "kajiya"}), 2, {"--unbiased", "kajiya"});
  expect_failure(adaptive({"--unbiased", "--max-spp", "64"}), 2, {"--unbiased", "--max-spp"});
  render(adaptive({"--unbiased", "--size", "40x24", "--report", path("r.json")}));
  expect_true_counts();
}

TEST_F(Adaptive, EveryEstimatorRendersAndReports) {
  for (const char* name :
       {"two-stream", "contrast", "painter-sloan", "chi-square", "kajiya", "dammertz"}) {
    SCOPED_TRACE(name);
    render(adaptive({"--estimator", name, "--size", "40x24", "--aov", "stop,variance", "--report",
                     path("r.json")}));
    expect_true_counts();
    const nlohmann::json json = read_json("r.json");
    EXPECT_EQ(json["error"]["estimator"], name);
    EXPECT_EQ(json["stopped"], false);
    EXPECT_NEAR(json["samples"]["mean"].get<double>(), 16.0, 0.7);
  }
}

TEST_F(Adaptive, ThresholdIsReachedAndReported) {
  render(adaptive({"--spp", "100000", "--noise-threshold", "0.02", "--size", "40x24", "--aov",
                   "stop", "--report", path("r.json")}));
  expect_true_counts();
  const nlohmann::json json = read_json("r.json");
  EXPECT_LE(json["error"]["estimate"].get<double>(), 0.02);
  EXPECT_LT(json["samples"]["mean"].get<double>(), 10000.0);
  const ExrPicture picture = read_exr(path("out.exr"));
  for (const float stop : picture.channels.at("stop")) ASSERT_EQ(stop, 2.0f);
}

TEST_F(Adaptive, DoesNotDependOnThreads) {
  for (const char* name : {"two-stream", "dammertz"}) {
    const Words frame = {"--estimator", name, "--size", "61x47", "--aov", "stop,variance"};
    render(adaptive(frame + Words{"--threads", "1"}));
    const ExrPicture one = read_exr(path("out.exr"));
    for (const char* threads : {"2", "7"}) {
      render(adaptive(frame + Words{"--threads", threads}));
      EXPECT_EQ(first_difference(read_exr(path("out.exr")), one), "") << name << ", " << threads;
    }
  }
}

TEST_F(Adaptive, ASignalLeavesACompletePictureWithTrueCounts) {
  // The first signal arrives during the first pass of a large frame, and the second arrives during
  // a later round of a small frame.
  const std::tuple<const char*, double, int> moments[] = {{"800x600", 0.3, SIGINT},
                                                          {"96x64", 0.4, SIGTERM}};
  for (const auto& [size, cpu_s, signal] : moments) {
    SCOPED_TRACE(std::string(size) + ", signal " + std::to_string(signal));
    Process process(adaptive({"--spp", "1000000", "--size", size, "--aov", "stop", "--verbose",
                              "--report", path("r.json")}),
                    {.folder = folder_.path()});
    ASSERT_TRUE(process.wait_until_busy("loaded in", cpu_s * kSanitizerSlowdown))
        << process.error_so_far();
    process.send(signal);
    const RunResult result = process.wait();
    EXPECT_EQ(result.exit_code, 130) << result.describe();
    EXPECT_NE(result.err.find("stopped after"), std::string::npos) << result.err;
    expect_true_counts();
    EXPECT_EQ(read_json("r.json")["stopped"], true);
    EXPECT_EQ(read_json("r.json")["exit_code"], 130);
    const ExrPicture picture = read_exr(path("out.exr"));
    const std::vector<float>&samples = picture.channels.at("samples"),
          &stops = picture.channels.at("stop");
    size_t by_user = 0;
    for (size_t i = 0; i < samples.size(); ++i) {
      ASSERT_EQ(samples[i] == 0.0f, stops[i] == 0.0f) << "pixel " << i;
      by_user += stops[i] == 5.0f;
    }
    EXPECT_GT(by_user, 0u);
    EXPECT_EQ(files(), (Words{"out.exr", "r.json", "scene.glb"}));
  }
}

TEST_F(Adaptive, TimeLimitIsNotAFailure) {
  const RunResult result = render(adaptive({"--spp", "1000000", "--size", "128x96", "--aov", "stop",
                                            "--time-limit", "0.2", "--report", path("r.json")}));
  EXPECT_LT(result.stop_cpu_s, 10.0 * kSanitizerSlowdown);  // of the whole run: no signal is sent
  expect_true_counts();
  const nlohmann::json json = read_json("r.json");
  EXPECT_EQ(json["exit_code"], 0);
  EXPECT_LT(json["samples"]["mean"].get<double>(), 1e6);
  const std::vector<float> stops = read_exr(path("out.exr")).channels.at("stop");
  EXPECT_NE(std::ranges::find(stops, 4.0f), stops.end());
}

// The forecast says how long the frame takes in all, and how many samples it will have.
TEST_F(Adaptive, ReportHasAForecast) {
  render(adaptive({"--spp", "64", "--size", "32x32", "--report", path("r.json")}));
  const nlohmann::json forecast = read_json("r.json")["forecast"];
  EXPECT_NEAR(double(forecast["samples_per_pixel"]), 64.0, 1.0);
  const double after = forecast["after_s"], seconds = forecast["render_s"];
  EXPECT_GT(after, 0.0);
  EXPECT_GE(seconds, after);
  EXPECT_LE(forecast["render_s_least"], seconds);
  EXPECT_GE(forecast["render_s_most"], seconds);
  // The log has it, and so has a frame with a threshold, whose number of samples is not given.
  const RunResult result =
      render({"render", scene(), "-o", path("out.exr"), "--size", "32x32", "--driver", "adaptive",
              "--noise-threshold", "0.01", "--report", path("r.json"), "--verbose"});
  EXPECT_NE(result.err.find("expected rendering time"), std::string::npos) << result.describe();
  const nlohmann::json threshold = read_json("r.json");
  const double expected = threshold["forecast"]["samples_per_pixel"];
  EXPECT_GT(expected, 8.0);
  EXPECT_LT(expected, 4096.0);
  // Every pixel of a bucket frame has the same number of samples, so nothing is to be predicted.
  render(render_words({"--report", path("r.json")}));
  EXPECT_TRUE(read_json("r.json")["forecast"].is_null());
}

}  // namespace
}  // namespace emberline::test
