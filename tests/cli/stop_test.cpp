// Tests stop signals. After a signal, the command must soon write the unfinished frame.
#include <algorithm>
#include <csignal>
#include <nlohmann/json.hpp>
#include <numeric>
#include <thread>

#include "cli/command_test.h"

namespace emberline::test {
namespace {

// "Soon" is measured in processor time, which other load does not affect. A run that does not stop
// would take hours, so it is killed and counts as hung.
class Stop : public CommandTest {
 protected:
  // The log contains this text just before the first sample.
  static constexpr const char* kRendering = "loaded in";

  // Returns the words of a frame that takes hours.
  Words endless(const Words& more = {}) {
    return Words{"render", scene(), "-o",        path("out.exr"), "--size",      "1024x1024",
                 "--spp",  "4096",  "--verbose", "--report",      path("r.json")} +
           more;
  }
  // Returns "emberline:complete" and "emberline:samples" from the header. Blanks may follow these
  // values.
  static std::pair<std::string, uint64_t> state_of(const ExrPicture& picture) {
    const std::string& complete = picture.attributes.at("emberline:complete");
    return {complete.substr(0, complete.find(' ')),
            std::stoull(picture.attributes.at("emberline:samples"))};
  }
};

// If rendering is complete but denoising is not, pixels that are not denoised must be written raw,
// and the checkpoint must contain all samples.
TEST_F(Stop, DuringTheDenoisingPass) {
  const Words frame = {"render",    scene(),     "-o",      path("out.exr"), "--size",
                       "400x300",   "--spp",     "16",      "--max-depth",   "1",
                       "--denoise", "--verbose", "--resume"};
  Process process(frame, {.folder = folder_.path()});
  ASSERT_TRUE(process.wait_for_error("denoising", 60 * kSanitizerSlowdown))
      << process.error_so_far();
  process.send(SIGTERM);
  const RunResult result = process.wait();
  EXPECT_EQ(result.exit_code, 130) << result.describe();
  EXPECT_LT(result.stop_cpu_s, 5.0 * kSanitizerSlowdown);
  EXPECT_NE(result.err.find("denoising was stopped"), std::string::npos) << result.err;
  const ExrPicture picture = read_exr(path("out.exr"));
  EXPECT_EQ(state_of(picture).first, "false");
  const std::vector<float>& raw = picture.channels.at("R");
  EXPECT_EQ(picture.channels.at("denoised.R").back(), raw.back());
  EXPECT_EQ(picture.channels.at("denoised.error").back(), 0.5f);
  const RunResult again = run(frame);
  EXPECT_EQ(again.exit_code, 0) << again.describe();
  const ExrPicture whole = read_exr(path("out.exr"));
  EXPECT_EQ(state_of(whole).first, "true");
  EXPECT_EQ(whole.channels.at("R"), raw);
  EXPECT_LT(whole.channels.at("denoised.error").back(), 0.5f);
}

TEST_F(Stop, WritesThePictureWithTrueSampleCounts) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGXCPU}) {
    SCOPED_TRACE(signal);
    // The buckets have only 16 x 16 pixels with 64 samples each, so some of them are finished soon.
    Process process(
        endless({"--bucket-size", "16", "--spp", "64", "--size", "640x640", "-o", path("out.png")}),
        {.folder = folder_.path()});
    ASSERT_TRUE(process.wait_until_busy(kRendering, 0.3 * kSanitizerSlowdown))
        << process.error_so_far();
    process.send(signal);
    const RunResult result = process.wait();
    EXPECT_EQ(result.exit_code, 130) << result.describe();
    EXPECT_LT(result.stop_cpu_s, 2.0 * kSanitizerSlowdown) << "asked to be at once";
    EXPECT_NE(result.err.find("stopped after"), std::string::npos) << result.err;
    const ExrPicture picture = read_exr(path("out.exr"));
    const std::vector<float>& samples = picture.channels.at("samples");
    const nlohmann::json json = read_json("r.json");
    const double sum = std::accumulate(samples.begin(), samples.end(), 0.0);
    EXPECT_GT(sum, 0.0);
    EXPECT_LT(sum, 64.0 * 640 * 640);
    EXPECT_EQ(json["samples"]["total"], uint64_t(sum));
    EXPECT_EQ(state_of(picture), std::pair(std::string("false"), uint64_t(sum)));
    EXPECT_EQ(json["samples"]["min"], uint64_t(*std::ranges::min_element(samples)));
    EXPECT_EQ(json["samples"]["max"], uint64_t(*std::ranges::max_element(samples)));
    EXPECT_EQ(json["stopped"], true);
    EXPECT_EQ(json["exit_code"], 130);
    EXPECT_EQ(read_bytes_picture(path("out.png")).width, 640);
    EXPECT_EQ(files(), (Words{"out.exr", "out.png", "r.json", "scene.glb"}));
  }
}

// A finished bucket of a stopped frame must have the same bits as this bucket of the whole frame.
TEST_F(Stop, FinishedPixelsEqualThoseOfTheWholeFrame) {
  const Words frame = {"--bucket-size", "8", "--spp", "32", "--size", "1024x1024"};
  Process process(endless(frame), {.folder = folder_.path()});
  ASSERT_TRUE(process.wait_until_busy(kRendering, 0.3 * kSanitizerSlowdown));
  process.send(SIGINT);
  ASSERT_EQ(process.wait().exit_code, 130);
  const ExrPicture stopped = read_exr(path("out.exr"));
  // The buckets follow a Hilbert curve, which starts in the first corner.
  ASSERT_EQ(stopped.at("samples", 0, 0), 32.0f);
  ASSERT_EQ(stopped.at("samples", 1023, 0), 0.0f);
  EXPECT_EQ(stopped.at("R", 1023, 0), 0.0f);
  render(endless(frame + Words{"--crop", "0,0,8,8"}));
  EXPECT_EQ(first_difference(read_exr(path("out.exr")), stopped), "");
}

// A time limit is not an error. The exit code must be 0 although the frame is partial, and every
// pixel must have a stop reason.
TEST_F(Stop, AtTheTimeLimit) {
  const double cores = std::thread::hardware_concurrency();
  for (const char* driver : {"bucket", "bisection"}) {
    SCOPED_TRACE(driver);
    const RunResult result = run(endless({"--driver", driver, "--time-limit", "0.3", "--size",
                                          "256x256", "--aov", "stop", "--bucket-size", "16"}));
    EXPECT_EQ(result.exit_code, 0) << result.describe();
    EXPECT_NE(result.err.find("time limit"), std::string::npos) << result.err;
    const nlohmann::json json = read_json("r.json");
    EXPECT_EQ(json["stopped"], true);
    EXPECT_EQ(json["stop_cause"], "time limit");
    EXPECT_EQ(json["exit_code"], 0);
    EXPECT_GE(json["time"]["render_s"].get<double>(), 0.3);
    EXPECT_LT(json["time"]["render_cpu_s"].get<double>(), (0.3 + 1.0 * kSanitizerSlowdown) * cores);
    EXPECT_EQ(json["passes"].back()["samples"], json["samples"]["total"]);
    const ExrPicture picture = read_exr(path("out.exr"));
    const std::vector<float>& samples = picture.channels.at("samples");
    const std::vector<float>& stops = picture.channels.at("stop");
    for (size_t i = 0; i < samples.size(); ++i) {
      ASSERT_EQ(stops[i], samples[i] == 0 ? 0.0f : samples[i] == 4096 ? 1.0f : 4.0f) << i;
    }
    const double sum = std::accumulate(samples.begin(), samples.end(), 0.0);
    EXPECT_EQ(json["samples"]["total"], uint64_t(sum));
    EXPECT_EQ(json["samples"]["pixels_without"], std::ranges::count(samples, 0.0f));
    // Missing buckets are holes. A progressive frame has no holes at any time limit.
    const bool holes = std::string(driver) == "bucket";
    EXPECT_EQ(result.err.find("of the pixels have no sample") != std::string::npos, holes)
        << result.err;
    EXPECT_EQ(state_of(picture), std::pair(std::string(holes ? "false" : "true"), uint64_t(sum)));
  }
}

TEST_F(Stop, StrictFailsForBlackPixelsAlone) {
  const Words limited = {"--time-limit", "0.3", "--size", "512x512", "--strict", "--quiet"};
  const auto frame = [&](const Words& more) {
    Words words = endless(limited + more);
    std::erase(words, "--verbose");
    return run(words);
  };
  const RunResult holes = frame({});
  EXPECT_EQ(holes.exit_code, 1) << holes.describe();
  EXPECT_NE(holes.err.find("have no sample and are black; --driver adaptive avoids this"),
            std::string::npos)
      << holes.err;
  EXPECT_EQ(read_json("r.json")["exit_code"], 1);
  EXPECT_EQ(state_of(read_exr(path("out.exr"))).first, "false") << "the picture is written";
  EXPECT_EQ(frame({"--driver", "adaptive"}).exit_code, 0);
  // If the frame can be resumed, the exit code must be 130, as without --strict.
  EXPECT_EQ(frame({"--resume"}).exit_code, 130);
}

// Unlike the bucket driver, a progressive driver must leave a complete frame whenever it is
// stopped.
TEST_F(Stop, AProgressiveFrameHasNoHoles) {
  Process process(endless({"--driver", "bisection", "--size", "512x512"}),
                  {.folder = folder_.path()});
  ASSERT_TRUE(process.wait_until_busy(kRendering, 0.3 * kSanitizerSlowdown));
  process.send(SIGINT);
  const RunResult result = process.wait();
  EXPECT_EQ(result.exit_code, 130) << result.describe();
  EXPECT_LT(result.stop_cpu_s, 2.0 * kSanitizerSlowdown);
  EXPECT_EQ(read_json("r.json")["stop_cause"], "user");
  // The scene has no sky, so alpha is above 0 only where a ray hits the floor or the lamp. This row
  // of the picture shows the floor.
  const ExrPicture picture = read_exr(path("out.exr"));
  for (int x = 0; x < 512; ++x) ASSERT_GT(picture.at("A", x, 350), 0.0f) << x;
}

TEST_F(Stop, StoppedFramesAreMarked) {
  Process process(endless({"--driver", "bisection", "--size", "64x64", "--spp", "1000000"}),
                  {.folder = folder_.path()});
  ASSERT_TRUE(process.wait_until_busy(kRendering, 0.2 * kSanitizerSlowdown));
  process.send(SIGINT);
  ASSERT_EQ(process.wait().exit_code, 130);
  const auto [complete, samples] = state_of(read_exr(path("out.exr")));
  const std::string expected_message =
      "out.exr: the frame was stopped before it was complete, at " + std::to_string(samples) +
      " samples";
  for (const Words& words : {Words{"compare", path("out.exr"), path("out.exr")},
                             Words{"heatmap", path("out.exr"), "-o", path("out.png")}}) {
    const RunResult shown = run(words);
    EXPECT_EQ(shown.exit_code, 0) << shown.describe();
    EXPECT_NE(shown.err.find(expected_message), std::string::npos) << shown.err;
  }
}

TEST_F(Stop, AFrameWithinItsTimeLimitIsNotStopped) {
  render(render_words({"--time-limit", "50", "--report", path("r.json")}));
  EXPECT_EQ(read_json("r.json")["stopped"], false);
  EXPECT_TRUE(read_json("r.json")["stop_cause"].is_null());
}

TEST_F(Stop, ASecondSignalEndsAtOnceAndLeavesNothing) {
  write("out.exr", "last night's good frame");
  Process process(endless(), {.folder = folder_.path()});
  ASSERT_TRUE(process.wait_until_busy(kRendering, 0.2 * kSanitizerSlowdown));
  process.send(SIGINT);
  process.send(SIGTERM);
  const RunResult result = process.wait();
  EXPECT_EQ(result.exit_code, 130) << result.describe();
  EXPECT_LT(result.stop_cpu_s, 1.0 * kSanitizerSlowdown);
  EXPECT_EQ(files(), (Words{"out.exr", "scene.glb"}));
  EXPECT_EQ(read_bytes(path("out.exr")).size(), 23u);
}

// A farm may kill a run without warning. The next run of the frame must remove the temporary files
// of the killed run, but not those of a run that is still alive.
TEST_F(Stop, NextRunRemovesFilesOfKilledRuns) {
  Process living(endless({"-o", path("out.png")}), {.folder = folder_.path()});
  ASSERT_TRUE(living.wait_until_busy(kRendering, 0.1 * kSanitizerSlowdown))
      << living.error_so_far();
  living.send(SIGSTOP);  // so that it takes no processor time from the other runs
  const Words in_use = files();
  for (int i = 0; i < 2; ++i) {
    Process killed(endless({"-o", path("out.png")}), {.folder = folder_.path()});
    ASSERT_TRUE(killed.wait_until_busy(kRendering, 0.1 * kSanitizerSlowdown))
        << killed.error_so_far();
    killed.send(SIGKILL);
    killed.wait();
  }
  EXPECT_GT(files().size(), in_use.size());
  render(render_words({"-o", path("out.png")}));
  Words expected = in_use + Words{"out.exr", "out.png"};
  std::ranges::sort(expected);
  EXPECT_EQ(files(), expected);
  living.send(SIGCONT);
  living.send(SIGINT);
  EXPECT_EQ(living.wait().exit_code, 130);
  EXPECT_EQ(files(), (Words{"out.exr", "out.png", "r.json", "scene.glb"}));
  EXPECT_EQ(read_exr(path("out.exr")).data.width(), 1024);
}

// The kernel repeats SIGXCPU every second, until the process reaches the hard limit and is killed.
// The second signal must not end the process.
TEST_F(Stop, ToleratesRepeatedProcessorTimeSignals) {
  Process process(endless({"--size", "512x512"}), {.folder = folder_.path()});
  ASSERT_TRUE(process.wait_until_busy(kRendering, 0.2 * kSanitizerSlowdown));
  process.send(SIGXCPU);
  process.send(SIGXCPU);
  EXPECT_EQ(process.wait().exit_code, 130);
  EXPECT_EQ(files(), (Words{"out.exr", "r.json", "scene.glb"}));
}

TEST_F(Stop, AnIgnoredSignalStaysIgnored) {
  for (const int signal : {SIGHUP, SIGQUIT}) {
    SCOPED_TRACE(signal);
    // The frame is so small that it would stop within a tenth of the time for which the test waits.
    Process process(endless({"--size", "128x128", "--spp", "1000000", "--bucket-size", "16"}),
                    {.folder = folder_.path(), .ignored_signal = signal});
    ASSERT_TRUE(process.wait_until_busy(kRendering, 0.2 * kSanitizerSlowdown));
    process.send(signal);
    EXPECT_TRUE(process.wait_until_busy(kRendering, 0.6 * kSanitizerSlowdown)) << "it has stopped";
    process.send(SIGINT);
    EXPECT_EQ(process.wait().exit_code, 130);
  }
}

TEST_F(Stop, HugeFramesStopQuickly) {
  Process process(endless({"--size", "16384x16384"}), {.folder = folder_.path()});
  ASSERT_TRUE(process.wait_until_busy(kRendering, 0.2 * kSanitizerSlowdown));
  process.send(SIGINT);
  const RunResult result = process.wait();
  EXPECT_EQ(result.exit_code, 130) << result.describe();
  // The command must fill 65536 tiles quickly, so it may not compress each of them separately.
  EXPECT_LT(result.stop_cpu_s, 5.0 * kSanitizerSlowdown);
  EXPECT_FALSE(result.hung);
}

TEST_F(Stop, UndisturbedFrameIsNotMarkedAsStopped) {
  render(render_words({"--report", path("r.json")}));
  EXPECT_EQ(read_json("r.json")["stopped"], false);
  EXPECT_EQ(state_of(read_exr(path("out.exr"))), std::pair(std::string("true"), uint64_t(16 * 16)));
}

}  // namespace
}  // namespace emberline::test
