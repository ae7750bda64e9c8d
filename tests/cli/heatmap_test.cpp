// Tests heatmaps that `render` writes and heatmaps that are made later from its EXR, with every
// quantity and format, and refused options. tests/unit tests what the pictures show.

#include <algorithm>
#include <cmath>
#include <csignal>
#include <nlohmann/json.hpp>

#include "cli/command_test.h"

namespace emberline::test {
namespace {

const Words kQuantities = {"samples", "error", "stop", "time", "non_finite"};
const Words kAllChannels = {"--aov", "variance,stop,time,non_finite"};

class Heatmap : public CommandTest {
 protected:
  Words of(const std::string& driver, const Words& more = {}) {
    const Words streams =
        driver == "adaptive" ? Words{"--spp", "16"} : Words{"--spp", "4", "--streams", "2"};
    return render_words(Words{"--driver", driver, "--size", "40x24"} + streams + more);
  }
  // Runs `emberline heatmap` on out.exr.
  void heatmap(const std::string& name, const Words& more) {
    const RunResult result = run(Words{"heatmap", path("out.exr"), "-o", path(name)} + more);
    EXPECT_EQ(result.exit_code, 0) << result.describe();
    EXPECT_EQ(result.out, "");
  }
  // Expects that the RMS of the map equals the report's estimate. The estimate may be up to 5 %
  // larger, because it also counts undiscovered light, which belongs to no pixel.
  static void expect_errors_of_report(double rms_of_map, double estimate, double tolerance = 1e-4) {
    EXPECT_GT(rms_of_map, 0.0);
    EXPECT_LE(rms_of_map, (1 + tolerance) * estimate);
    EXPECT_GE(rms_of_map, (0.95 - tolerance) * estimate);
  }
  std::vector<unsigned char> bytes(const std::string& name) const {
    const auto read = read_bytes(path(name));
    return {read.begin(), read.end()};
  }
};

TEST_F(Heatmap, SameDuringTheRenderAndFromTheFile) {
  for (const char* driver : {"bucket", "bisection", "adaptive"}) {
    Words words = of(driver);
    for (const std::string& quantity : kQuantities) {
      words = words + Words{"--heatmap", path(quantity + ".png"), "--heatmap-of", quantity};
    }
    render(words);
    const ExrPicture picture = read_exr(path("out.exr"));
    for (const char* channel : {"variance.R", "stop", "time", "non_finite"}) {
      EXPECT_TRUE(picture.channels.contains(channel)) << channel << " is not added by itself";
    }
    // `emberline heatmap` does not depend on the driver. So it is enough to test each quantity with
    // one driver, and each driver with one quantity.
    for (const std::string& quantity : driver == std::string("adaptive") ? kQuantities
                                       : driver == std::string("bucket") ? Words{"samples", "time"}
                                                                         : Words{"error"}) {
      SCOPED_TRACE(std::string(driver) + ", " + quantity);
      heatmap("later.png", {"--of", quantity});
      EXPECT_EQ(bytes(quantity + ".png"), bytes("later.png"));
      const BytePicture drawn = read_bytes_picture(path("later.png"));
      EXPECT_EQ(drawn.channels, 3);
      EXPECT_GT(drawn.width, 40);
      EXPECT_GT(drawn.height, 24);
    }
  }
}

TEST_F(Heatmap, ExrHasTheValues) {
  Words words = of("adaptive", {"--estimator", "two-stream"});
  for (const std::string& quantity : kQuantities) {
    words = words + Words{"--heatmap", path(quantity + ".exr"), "--heatmap-of", quantity};
  }
  render(words);
  const ExrPicture frame = read_exr(path("out.exr"));
  for (const std::string& quantity : kQuantities) {
    const ExrPicture heatmap = read_exr(path(quantity + ".exr"));
    ASSERT_EQ(heatmap.channels.size(), 1u);
    EXPECT_EQ(heatmap.types.at(quantity), "float");
    if (quantity != "error") {
      EXPECT_EQ(heatmap.channels.at(quantity), frame.channels.at(quantity));
    }
  }
  // The legend and the report contain this RMS.
  double sum = 0;
  const ExrPicture errors = read_exr(path("error.exr"));
  for (const float error : errors.channels.at("error")) {
    ASSERT_TRUE(error >= 0.0f && error < 1.0f);
    sum += double(error) * double(error);
  }
  render(words + Words{"--report", path("r.json")});
  expect_errors_of_report(std::sqrt(sum / (40 * 24)), read_json("r.json")["error"]["estimate"]);
}

// The RMS of the map must match the report's estimate. The estimate includes the change made by the
// last doubling of samples. Map and estimate include the errors of all buckets.
TEST_F(Heatmap, ErrorsOfOneStreamMatchTheReport) {
  const Words threshold = {"--noise-threshold", "0.01"};
  const Words cases[] = {
      of("adaptive", {"--spp", "40"}),
      of("adaptive", {"--spp", "40", "--crop", "3,2,30,21"}),
      of("adaptive", {"--spp", "12"}),
      of("adaptive", {"--spp", "40", "--streams", "2"}),
      of("adaptive", {"--spp", "40", "--estimator", "two-stream"}),
      of("adaptive", {"--spp", "40", "--unbiased"}),
      of("adaptive", {"--spp", "40", "--unbiased", "--estimator", "two-stream"}),
      of("bucket", Words{"--spp", "64", "--streams", "1"} + threshold),
      of("bucket", Words{"--spp", "64", "--streams", "1", "--bucket-size", "16"} + threshold)};
  for (const Words& words : cases) {
    SCOPED_TRACE(testing::PrintToString(words));
    render(words + Words{"--heatmap", path("error.exr"), "--heatmap-of", "error", "--report",
                         path("r.json")});
    double sum = 0;
    const ExrPicture errors = read_exr(path("error.exr"));
    const std::vector<float>& values = errors.channels.at("error");
    for (const float error : values) sum += double(error) * double(error);
    // In an unbiased frame, the means in the output differ from the means with which the driver
    // placed pixels on the display curve.
    const bool unbiased = std::ranges::count(words, "--unbiased") > 0;
    expect_errors_of_report(std::sqrt(sum / double(values.size())),
                            read_json("r.json")["error"]["estimate"], unbiased ? 0.05 : 1e-4);
  }
}

TEST_F(Heatmap, CropShowsTheCrop) {
  const Words crop = {"--crop", "5,3,33,20"};
  render(of("bucket", crop + Words{"--heatmap", path("d.png"), "--plain", "--heatmap",
                                   path("d.exr"), "--spp", "8", "--noise-threshold", "0.05"}));
  const BytePicture drawn = read_bytes_picture(path("d.png"));
  EXPECT_EQ(drawn.width, 28);
  EXPECT_EQ(drawn.height, 17);
  const ExrPicture raw = read_exr(path("d.exr")), frame = read_exr(path("out.exr"));
  EXPECT_EQ(raw.data, (Rect{5, 3, 33, 20}));
  EXPECT_EQ(raw.display, (Rect{0, 0, 40, 24}));
  EXPECT_EQ(raw.channels.at("samples"), frame.channels.at("samples"));
  heatmap("later.exr", {});
  const ExrPicture later = read_exr(path("later.exr"));
  EXPECT_EQ(later.data, raw.data);
  EXPECT_EQ(later.display, raw.display);
  EXPECT_EQ(later.channels, raw.channels);
}

TEST_F(Heatmap, AUniformRenderLooksUniform) {
  for (const char* driver : {"bucket", "bisection"}) {
    render(of(driver, {"--heatmap", path("d.png"), "--plain"}));
    const BytePicture drawn = read_bytes_picture(path("d.png"));
    EXPECT_EQ(drawn.width, 40);
    for (const uint8_t value : drawn.values) ASSERT_EQ(value, 128);
  }
}

TEST_F(Heatmap, UsesTheRequestedStyle) {
  render(of("adaptive", kAllChannels));
  const ExrPicture frame = read_exr(path("out.exr"));
  heatmap("grey.png", {"--plain", "--range", "0,64"});
  const BytePicture grey = read_bytes_picture(path("grey.png"));
  for (int y = 0; y < 24; ++y) {
    for (int x = 0; x < 40; ++x) {
      const float samples = frame.at("samples", x, y);
      ASSERT_EQ(int(grey.at(x, y)[0]), int(std::lround(255 * std::min(1.0, double(samples) / 64))));
    }
  }
  // Each option must change the picture.
  std::vector<std::vector<unsigned char>> seen = {bytes("grey.png")};
  for (const Words& style :
       {Words{}, Words{"--log"}, Words{"--plain"}, Words{"--range", "1,100"},
        Words{"--range", "1,100", "--log"}, Words{"--colors", "viridis"},
        Words{"--colors", "inferno"}, Words{"--colors", "magma"}, Words{"--colors", "turbo"}}) {
    heatmap("d.png", style);
    EXPECT_EQ(std::ranges::count(seen, bytes("d.png")), 0);
    seen.push_back(bytes("d.png"));
  }
  heatmap("d.jpg", {});
  heatmap("d.JPEG", {});
  EXPECT_EQ(read_bytes_picture(path("d.jpg")).width, read_bytes_picture(path("d.JPEG")).width);
}

TEST_F(Heatmap, DoesNotDependOnThreads) {
  Words words;
  for (const char* quantity : {"samples", "error", "stop"}) {
    words =
        words + Words{"--heatmap", path(std::string(quantity) + ".png"), "--heatmap-of", quantity};
  }
  std::vector<std::vector<unsigned char>> first;
  for (const char* threads : {"1", "2", "7"}) {
    render(of("adaptive", words + Words{"--threads", threads}));
    std::vector<std::vector<unsigned char>> now;
    for (const char* quantity : {"samples", "error", "stop"}) {
      now.push_back(bytes(std::string(quantity) + ".png"));
    }
    if (first.empty()) first = now;
    EXPECT_EQ(now, first) << threads;
  }
}

TEST_F(Heatmap, StoppedRenderHasAHeatmap) {
  for (const char* driver : {"bucket", "adaptive"}) {
    SCOPED_TRACE(driver);
    Process process(
        {"render",        scene(),       "-o",           path("out.exr"), "--driver",
         driver,          "--spp",       "100000",       "--size",        "192x192",
         "--bucket-size", "8",           "--verbose",    "--heatmap",     path("d.png"),
         "--heatmap",     path("s.png"), "--heatmap-of", "samples",       "--heatmap-of",
         "stop"},
        {.folder = folder_.path()});
    ASSERT_TRUE(process.wait_until_busy("loaded in", 0.2 * kSanitizerSlowdown))
        << process.error_so_far();
    process.send(SIGINT);
    const RunResult result = process.wait();
    EXPECT_EQ(result.exit_code, 130) << result.describe();
    EXPECT_EQ(files(), (Words{"d.png", "out.exr", "s.png", "scene.glb"}));
    // The heatmap must equal the heatmap made from the EXR.
    heatmap("later.png", {});
    EXPECT_EQ(bytes("d.png"), bytes("later.png"));
    heatmap("later.png", {"--of", "stop"});
    EXPECT_EQ(bytes("s.png"), bytes("later.png"));
    std::filesystem::remove(path("later.png"));
  }
}

TEST_F(Heatmap, ReportsTheMemoryOfMaps) {
  const auto film_bytes = [&](const Words& more) {
    render(of("bucket", Words{"--size", "400x300", "--spp", "1", "--threads", "1", "--report",
                              path("r.json")} +
                            more));
    return read_json("r.json")["memory"]["film_bytes"].get<int64_t>();
  };
  const int64_t without = film_bytes({});
  EXPECT_EQ(film_bytes({"--heatmap", path("d.png")}) - without, 4 * 400 * 300);
}

// The saving is the ratio of squared error times time, as sums over 5x5 pixels.
TEST_F(Heatmap, SavingAgainstAnotherFrame) {
  const Words aovs = {"--aov", "variance,time"};
  render(of("bucket", aovs));
  render(Words{"render", scene(), "-o", path("other.exr"), "--size", "40x24", "--spp", "16"} +
         aovs);
  const auto costs = [&](const std::string& frame) {
    std::vector<double> values(40 * 24);
    render({"heatmap", path(frame), "--of", "error", "-o", path("error.exr")});
    render({"heatmap", path(frame), "--of", "time", "-o", path("time.exr")});
    const ExrPicture error = read_exr(path("error.exr")), time = read_exr(path("time.exr"));
    for (int y = 0; y < 24; ++y) {
      for (int x = 0; x < 40; ++x) {
        for (int v = std::max(y - 2, 0); v < std::min(y + 3, 24); ++v) {
          for (int u = std::max(x - 2, 0); u < std::min(x + 3, 40); ++u) {
            const double e = double(error.at("error", u, v));
            values[size_t(y * 40 + x)] += e * e * double(time.at("time", u, v));
          }
        }
      }
    }
    return values;
  };
  const std::vector<double> one = costs("out.exr"), other = costs("other.exr");
  heatmap("saving.exr", {"--against", path("other.exr")});
  const ExrPicture saving = read_exr(path("saving.exr"));
  int compared = 0;
  for (size_t i = 0; i < one.size(); ++i) {
    const float value = saving.channels.at("saving")[i];
    EXPECT_EQ(std::isnan(value), one[i] == 0);
    if (std::isnan(value)) continue;
    EXPECT_NEAR(double(value), other[i] / one[i], 1e-4 * other[i] / one[i]);
    ++compared;
  }
  EXPECT_GT(compared, 400);
  heatmap("saving.png", {"--against", path("other.exr"), "--log", "--colors", "viridis"});
  EXPECT_GT(read_bytes_picture(path("saving.png")).height, 24);

  const Words against = {"heatmap", path("out.exr"), "-o", path("d.png"), "--against"};
  expect_failure(against + Words{path("other.exr"), "--of", "time"}, 2, {"--against", "--of"});
  expect_failure(against + Words{path("d.png")}, 2, {"d.png", "--against"});
  render(Words{"render", scene(), "-o", path("small.exr"), "--size", "40x23", "--spp", "4"} + aovs);
  expect_failure(against + Words{path("small.exr")}, 3, {"small.exr", "size"});
  render({"render", scene(), "-o", path("plain.exr"), "--size", "40x24", "--spp", "4"});
  expect_failure(against + Words{path("plain.exr")}, 3, {"plain.exr", "variance"});
}

TEST_F(Heatmap, WrongStylesAndCounts) {
  const Words d = {"--heatmap", path("d.png")}, e = {"--heatmap", path("e.png")};
  expect_failure(render_words({"--heatmap-of", "error"}), 2, {"--heatmap-of requires --heatmap"});
  for (const char* option : {"--log", "--plain"}) {
    expect_failure(render_words({option}), 2, {option, "requires --heatmap"});
  }
  expect_failure(render_words(d + Words{"--heatmap-of", "samples", "--heatmap-of", "error"}), 2,
                 {"--heatmap-of error", "no --heatmap belongs to it"});
  expect_failure(render_words(d + Words{"--log", "--range", "0,5"}), 2, {"--range", "--log"});
  expect_failure(render_words(d + Words{"--heatmap-of", "stop", "--range", "0,5"}), 2,
                 {"--range", "stop", "reasons"});
  expect_failure(render_words(d + Words{"--heatmap-of", "stop", "--log"}), 2,
                 {"--log", "stop", "reasons"});
  expect_failure(render_words(d + e + Words{"--heatmap-of", "error", "--range", "0,5"}), 2,
                 {"--range", "error and samples"});
  expect_failure(render_words(d + d), 2, {"--heatmap", "d.png", "it is also written by"});
  expect_failure(render_words({"--heatmap", path("out.exr")}), 2,
                 {"--heatmap", "it is also written by"});
  expect_failure(render_words({"--heatmap", scene()}), 2, {"--heatmap", "unknown format"});
  expect_failure(render_words(d + Words{"--report", path("d.png")}), 2,
                 {"--report", "it is also written by"});
  expect_failure(render_words({"--heatmap", path("d.jpg"), "--size", "50001x1"}), 2,
                 {"--heatmap", "50000"});
  // Two heatmaps of the same quantity may share a range.
  render(render_words(d + e + Words{"--range", "0,5"}));
  EXPECT_EQ(bytes("d.png"), bytes("e.png"));
}

TEST_F(Heatmap, OutputPathIsCheckedBeforeTheRender) {
  for (const char* name : {"missing/d.png", "missing/d.exr"}) {
    expect_failure({"render", path("no scene.glb"), "-o", path("out.exr"), "--heatmap", path(name)},
                   1, {name, "does not exist"});
  }
  write("d.png", "last night's");
  expect_failure(render_words({"--heatmap", path("d.png"), "--report", path("missing/r.json")}), 1,
                 {"missing/r.json"});
  EXPECT_EQ(bytes("d.png").size(), 12u);
}

TEST_F(Heatmap, FileWithoutTheNeededChannels) {
  render(render_words());
  const Words input = {"heatmap", path("out.exr")};
  const std::pair<const char*, Words> missing[] = {{"error", {"\"variance.R\"", "--aov variance"}},
                                                   {"stop", {"\"stop\"", "--aov stop"}},
                                                   {"time", {"\"time\"", "--aov time"}},
                                                   {"non_finite", {"--aov non_finite"}}};
  for (const auto& [quantity, message_parts] : missing) {
    expect_failure(input + Words{"-o", path("d.png"), "--of", quantity}, 3,
                   Words{"out.exr", "no channel named"} + message_parts);
  }
  render(render_words({"-o", path("out.png")}));
  expect_failure({"heatmap", path("out.png"), "-o", path("d.png")}, 3,
                 {"out.png", "no channel named \"samples\"", "`emberline render`"});
  expect_failure({"heatmap", path("none.exr"), "-o", path("d.png")}, 3, {"none.exr"});
  expect_failure({"heatmap", scene(), "-o", path("d.png")}, 3, {"scene.glb"});
  expect_failure(input + Words{"-o", path("out.exr")}, 2, {"-o", "out.exr", "itself"});
  expect_failure(input + Words{"-o", path("d.tif")}, 2, {"-o", ".exr, .png, .jpg, .jpeg"});
  expect_failure(input + Words{"-o", path("missing/d.png")}, 1, {"missing/d.png"});
  expect_failure(
      input + Words{"-o", path("d.png"), "--of", "speed"}, 2,
      {"--of", "valid names are samples, error, denoised_error, stop, judge, time, non_finite"});
  expect_failure(input + Words{"-o", path("d.png"), "--colors", "jet"}, 2,
                 {"--colors", "valid names are grey, viridis, inferno, magma, turbo"});
  expect_failure(input + Words{"-o", path("d.png"), "--range", "2,1"}, 2, {"--range", "MIN,MAX"});
  expect_failure(input + Words{"-o", path("d.png"), "--log", "--range", "-1,1"}, 2, {"--range"});
  expect_failure(input, 2, {"-o"});
}

}  // namespace
}  // namespace emberline::test
