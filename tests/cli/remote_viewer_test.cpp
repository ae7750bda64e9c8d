// Tests `--display tev://HOST:PORT`. The viewer must get the same picture as the file, and must not
// delay or change the render.

#include <algorithm>
#include <chrono>
#include <csignal>
#include <nlohmann/json.hpp>

#include "cli/command_test.h"
#include "support/tev_server.h"

namespace emberline::test {
namespace {

double seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

constexpr const char* kChannels[] = {"R", "G", "B", "A"};

// Expects that the viewer's image has the bits of the file in the file's data window, and is black
// elsewhere.
void expect_same_picture(const TevImage& image, const ExrPicture& file) {
  ASSERT_EQ((Rect{0, 0, image.width, image.height}), file.display);
  ASSERT_EQ(image.channels, Words(std::begin(kChannels), std::end(kChannels)));
  for (const char* channel : kChannels) {
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        const float expected = file.data.contains(x, y) ? file.at(channel, x, y) : 0.0f;
        const float shown = image.at(channel, x, y);
        ASSERT_EQ(std::memcmp(&shown, &expected, sizeof shown), 0)
            << channel << " of " << x << "," << y << ": " << shown << ", file " << expected;
      }
    }
  }
}

class RemoteViewer : public CommandTest {
 protected:
  Words frame(const std::string& url, const Words& more = {}) {
    return Words{"render", scene(), "-o",        "out.exr", "--size",   "150x100",
                 "--spp",  "4",     "--display", url,       "--report", "r.json"} +
           more;
  }
  ExrPicture file() const { return read_exr(path("out.exr")); }

  // Expects exit code 0 and exactly one warning, which names the viewer.
  void expect_one_warning(const RunResult& result, const std::string& url,
                          const std::string& what) {
    EXPECT_EQ(result.exit_code, 0) << result.describe();
    const Words lines = result.error_lines();
    EXPECT_EQ(std::ranges::count_if(
                  lines, [](const auto& l) { return l.find("warning") != std::string::npos; }),
              1)
        << result.err;
    EXPECT_NE(result.err.find("emberline: warning: --display " + url + ": "), std::string::npos)
        << result.err;
    EXPECT_NE(result.err.find(what), std::string::npos) << result.err;
    EXPECT_EQ(read_json("r.json")["warnings"].size(), 1u);
  }
};

TEST_F(RemoteViewer, GetsTheSamePictureAsTheFile) {
  const Words variants[] = {
      {},
      {"--crop", "37,20,140,91"},
      {"--bucket-size", "7", "--bucket-order", "random"},
      {"--bucket-size", "300", "--size", "280x270", "--spp", "1"},
      {"--noise-threshold", "0.05", "--unbiased", "--bucket-size", "32"},
      {"--driver", "bisection"},
      {"--driver", "bisection", "--crop", "37,20,140,91", "--bucket-size", "5"},
      {"--driver", "adaptive"},
      {"--driver", "adaptive", "--unbiased", "--crop", "37,20,140,91", "--bucket-size", "16"},
      {"--transparent", "--threads", "1"},
  };
  for (const Words& variant : variants) {
    SCOPED_TRACE(variant.empty() ? "" : variant.front() + " " + variant[1]);
    TevServer server;
    const RunResult result = render(frame(server.url(), variant));
    EXPECT_EQ(server.wait(), "");
    EXPECT_EQ(result.err.find("warning"), std::string::npos) << result.err;
    ASSERT_EQ(server.images().size(), 1u);
    EXPECT_EQ(server.images().begin()->first, "out.exr (scene.glb)");
    expect_same_picture(server.image(), file());
  }
}

TEST_F(RemoteViewer, GetsEveryBucketOnce) {
  TevServer server;
  render(frame(server.url(), {"--bucket-size", "50"}));
  EXPECT_EQ(server.wait(), "");
  EXPECT_EQ(server.image().updates.size(), 6u);
}

TEST_F(RemoteViewer, SeesAProgressiveFrameGrow) {
  for (const char* driver : {"bisection", "adaptive"}) {
    SCOPED_TRACE(driver);
    constexpr size_t kTiles = 3 * 2;  // tiles per picture
    size_t pictures = 0;
    // On a busy machine the render gets less processor time, so try again with more time.
    for (double limit_s = 0.5; limit_s <= 8.0 && pictures < 4; limit_s *= 2.0) {
      TevServer server;
      render(frame(server.url(), {"--driver", driver, "--spp", "1000000", "--time-limit",
                                  std::to_string(limit_s * kSanitizerSlowdown)}));
      EXPECT_EQ(server.wait(), "");
      const TevImage& image = server.image();
      pictures = image.updates.size() / kTiles;
      // Each tile has at most one update per tenth of a second, plus the last update.
      EXPECT_LE(image.updates.size(), kTiles * size_t(2.0 + 10.0 * limit_s * kSanitizerSlowdown));
      expect_same_picture(image, file());
    }
    EXPECT_GE(pictures, 4u) << "the first at once, the last at the end, and some between";
  }
}

TEST_F(RemoteViewer, WorksTogetherWithTheDisplayOfThePng) {
  render(frame("sRGB", {"-o", "plain.png", "--view", "ACES"}));
  const ExrPicture without = file();
  TevServer server;
  render(frame(server.url(), {"-o", "seen.png", "--view", "ACES", "--display", "sRGB"}));
  EXPECT_EQ(server.wait(), "");
  EXPECT_EQ(read_bytes_picture(path("seen.png")).values,
            read_bytes_picture(path("plain.png")).values);
  EXPECT_EQ(first_difference(without, file()), "");
  expect_same_picture(server.image(), file());
  // An invalid display name must also be refused if a viewer is given after it.
  expect_failure(
      {"render", scene(), "-o", "a.png", "--display", "nope", "--display", "tev://localhost"}, 2,
      {"unknown display", "nope", "sRGB"});
}

TEST_F(RemoteViewer, LastOfTwoWins) {
  TevServer first, last;
  render(frame(first.url(), {"--display", last.url()}));
  EXPECT_EQ(last.wait(), "");
  EXPECT_FALSE(first.connected());
  expect_same_picture(last.image(), file());
}

TEST_F(RemoteViewer, MissingViewerIsAWarning) {
  std::string url;
  {
    const TevServer server;
    url = server.url();
  }
  expect_one_warning(run(frame(url)), url, "cannot connect");
  EXPECT_EQ(file().at("samples", 149, 99), 4.0f);
  expect_one_warning(run(frame("tev://no-such-host.invalid")), "tev://no-such-host.invalid:14158",
                     "cannot find the host");
  const RunResult quiet = run(frame(url, {"--quiet"}));
  EXPECT_EQ(quiet.exit_code, 0);
  EXPECT_EQ(quiet.err, "");
}

TEST_F(RemoteViewer, ClosingViewerIsAWarning) {
  for (const char* driver : {"bucket", "bisection"}) {
    SCOPED_TRACE(driver);
    TevServer server({.closes_after = 60000});
    const RunResult result = run(frame(server.url(), {"--size", "400x300", "--bucket-size", "16",
                                                      "--spp", "4", "--driver", driver}));
    expect_one_warning(result, server.url(), "");
    const std::vector<float> samples = file().channels.at("samples");
    EXPECT_TRUE(std::ranges::all_of(samples, [](float s) { return s == 4.0f; }));
  }
}

TEST_F(RemoteViewer, SlowViewerDoesNotDelayTheRender) {
  // The adaptive driver is not tested, because its frames are shown in the same way as those of the
  // bisection driver.
  for (const char* driver : {"bucket", "bisection"}) {
    SCOPED_TRACE(driver);
    const Words work = {"--size", "1024x768", "--spp", "1", "--driver", driver, "--max-depth", "1"};
    // Other load may delay one of the two runs, but not ten times in a row.
    bool in_time = false;
    for (int tries = 0; tries < 10 && !in_time && !HasFailure(); ++tries) {
      const RunResult alone = render(frame("sRGB", work));
      const ExrPicture without = file();
      TevServer server({.reads = false});
      const RunResult result = run(frame(server.url(), work));
      expect_one_warning(result, server.url(), "stopped reading");
      EXPECT_EQ(first_difference(file(), without), "");
      const nlohmann::json time = read_json("r.json")["time"];
      EXPECT_GE(time["write_s"].get<double>(), 1.0) << "the wait is no rendering";
      // Allows for the second that the viewer gets to recover, and for variation between runs.
      in_time = result.seconds < 1.5 * alone.seconds + 2.0 * kSanitizerSlowdown;
    }
    EXPECT_TRUE(in_time);
  }
}

TEST_F(RemoteViewer, SlowViewerDoesNotDelayAStop) {
  for (const char* driver : {"bucket", "bisection"}) {
    SCOPED_TRACE(driver);
    // Other load or the disk may delay the stop, but not ten times in a row.
    double stop_s = 1e9, write_s = 1e9;
    for (int tries = 0;
         tries < 10 && (stop_s >= 2.0 * kSanitizerSlowdown || write_s >= kSanitizerSlowdown);
         ++tries) {
      TevServer server({.reads = false});
      Process process(frame(server.url(), {"--size", "512x512", "--spp", "2048", "--verbose",
                                           "--bucket-size", "16", "--driver", driver}),
                      {.folder = folder_.path()});
      ASSERT_TRUE(process.wait_until_busy("loaded in", 0.5 * kSanitizerSlowdown))
          << process.error_so_far();
      process.send(SIGINT);
      const double sent = seconds();
      EXPECT_EQ(process.wait().exit_code, 130);
      stop_s = std::min(stop_s, seconds() - sent);
      write_s = std::min(write_s, read_json("r.json")["time"]["write_s"].get<double>());
    }
    EXPECT_LT(stop_s, 2.0 * kSanitizerSlowdown);
    // The limit is less than the second that a viewer gets to recover when nothing else waits. The
    // frame is small, because on a slow machine compressing a larger frame would take that long.
    EXPECT_LT(write_s, 1.0 * kSanitizerSlowdown);
  }
}

TEST_F(RemoteViewer, GetsTheWrittenPictureOfAStoppedFrame) {
  TevServer server;
  Process process(frame(server.url(),
                        {"--size", "512x512", "--spp", "1024", "--verbose", "--bucket-size", "16"}),
                  {.folder = folder_.path()});
  ASSERT_TRUE(process.wait_until_busy("loaded in", 0.4 * kSanitizerSlowdown))
      << process.error_so_far();
  process.send(SIGINT);
  EXPECT_EQ(process.wait().exit_code, 130);
  EXPECT_EQ(server.wait(), "");
  expect_same_picture(server.image(), file());
}

TEST_F(RemoteViewer, IsNotContactedForABrokenScene) {
  TevServer server;
  write("broken.glb", "no scene");
  expect_failure({"render", path("broken.glb"), "-o", "a.exr", "--display", server.url()}, 3,
                 {"broken.glb"});
  EXPECT_FALSE(server.connected());
}

}  // namespace
}  // namespace emberline::test
