// Tests --denoise, `emberline denoise` and the channels that both use. With every driver, both must
// write the same bits. Also tests incomplete files. The tests of the filter check its quality.
#include <cmath>
#include <nlohmann/json.hpp>

#include "cli/command_test.h"

namespace emberline::test {
namespace {

const Words kDenoised = {"--denoise"};
const Words kResults = {"denoised.R", "denoised.G", "denoised.B", "denoised.error"};

class Denoise : public CommandTest {
 protected:
  Words words(const Words& more) {
    return render_words(Words{"--spp", "16", "--size", "40x30"} + more);
  }
  ExrPicture picture(const Words& more, const std::string& name = "out.exr") {
    render(words(more));
    return read_exr(path(name));
  }
  std::string text(const std::string& name) const {
    const auto bytes = read_bytes(path(name));
    return {bytes.begin(), bytes.end()};
  }
  // Returns the output of `emberline denoise` for out.exr.
  ExrPicture later(const Words& more = {}) {
    const RunResult result = run(Words{"denoise", path("out.exr"), "-o", path("later.exr")} + more);
    EXPECT_EQ(result.exit_code, 0) << result.describe();
    EXPECT_EQ(result.out, "");
    return read_exr(path("later.exr"));
  }
};

// Expects that `b` has every channel of `a`, with the same bits.
void expect_within(const ExrPicture& a, const ExrPicture& b) {
  for (const auto& [name, values] : a.channels) {
    ASSERT_TRUE(b.channels.contains(name)) << name;
    EXPECT_EQ(b.channels.at(name), values) << name;
  }
}

// With every driver, the raw picture must be that of two streams, and the denoised picture must not
// depend on when it is computed (law 2 in renderer/README.md).
TEST_F(Denoise, SameDuringTheRenderAndFromTheFile) {
  const std::vector<Words> drivers = {{"--driver", "bucket", "--bucket-size", "9"},
                                      {"--driver", "bisection"},
                                      {"--driver", "adaptive"},
                                      {"--driver", "adaptive", "--unbiased"},
                                      {"--noise-threshold", "0.02"}};
  for (const Words& driver : drivers) {
    SCOPED_TRACE(driver.back());
    const ExrPicture raw = picture(driver + Words{"--streams", "2"});
    const ExrPicture kept = picture(driver + Words{"--aov", "denoising"});
    expect_within(raw, kept);
    const ExrPicture after = later();
    const ExrPicture now = picture(driver + kDenoised);
    expect_within(kept, now);
    expect_within(after, now);
    EXPECT_EQ(now.channels.size(), kept.channels.size() + kResults.size());
    EXPECT_EQ(now.channels.size(), after.channels.size());
    EXPECT_EQ(now.types, after.types);
    for (const std::string& name : kResults) {
      for (const float value : now.channels.at(name)) ASSERT_TRUE(std::isfinite(value)) << name;
    }
    // `emberline denoise` computes the results again if the file already has them.
    if (driver == drivers.front()) expect_within(now, later());
  }
}

// The contributions of samples to neighbouring pixels are summed before they are written. Files
// with the old layout, which had one layer per neighbour, are refused.
TEST_F(Denoise, SharedSamplesAreSummed) {
  const ExrPicture seen = picture({"--aov", "denoising"});
  EXPECT_EQ(seen.channels.size(), 5u + 2 * (12 + 3));
  const auto noise = [&](const std::string& layer) {
    const std::vector<float>&a = seen.channels.at("half1." + layer + "G"),
          &b = seen.channels.at("half2." + layer + "G");
    double sum = 0.0;
    for (size_t i = 0; i < a.size(); ++i) sum += std::pow(double(a[i] - b[i]), 2);
    return sum;
  };
  EXPECT_LT(noise("shared."), 0.9 * noise(""));
  for (const std::string half : {"half1.", "half2."}) {
    // The pixel is at the border.
    EXPECT_EQ(seen.at(half + "shared.G", 0, 7), seen.at(half + "G", 0, 7));
    EXPECT_FALSE(seen.channels.contains(half + "shared.0.R"));
  }
  // Make a file without the sums.
  std::string old = text("out.exr");
  for (const std::string half : {"half1.", "half2."}) {
    for (const std::string c : {"B", "G", "R"}) {
      const size_t at = old.find(half + "shared." + c);
      ASSERT_NE(at, std::string::npos);
      old.replace(at + half.size(), 6, "sharex");
    }
  }
  write("out.exr", old);
  expect_failure({"denoise", path("out.exr"), "-o", path("later.exr")}, 3,
                 {"half1.shared.R", "--aov denoising"});
}

TEST_F(Denoise, ThreadsAndBucketsDoNotMatter) {
  const ExrPicture one = picture(kDenoised + Words{"--threads", "1"});
  expect_within(one, picture(kDenoised + Words{"--threads", "4", "--bucket-size", "7"}));
  expect_within(one, later({"--threads", "3"}));
}

// The frame has more rows than are filtered at once, so it is filtered in bands. On both sides of a
// seam between bands, the bits must be the same as if the picture were filtered as a whole.
TEST_F(Denoise, ATallFrameIsFilteredInBands) {
  const Words tall = kDenoised + Words{"--size", "8x700", "--spp", "2"};
  const ExrPicture small = picture(tall + Words{"--bucket-size", "13"});
  const ExrPicture large = picture(tall + Words{"--bucket-size", "1024"});
  expect_within(small, large);
  expect_within(small, later());
}

TEST_F(Denoise, CropKeepsItsPlaceInTheFrame) {
  const ExrPicture crop = picture(kDenoised + Words{"--crop", "3,5,31,29"});
  EXPECT_EQ(crop.data, (Rect{3, 5, 31, 29}));
  const ExrPicture after = later();
  EXPECT_EQ(after.data, crop.data);
  EXPECT_EQ(after.display, crop.display);
  expect_within(crop, after);
}

// Compares only pixels away from the edges of the crop, because with the whole frame the filter
// also sees pixels beyond these edges.
TEST_F(Denoise, CropEqualsTheSamePartOfTheFrame) {
  constexpr int kReach = 48;  // slightly more than kDenoiseMargin
  const Words large = {"--size", "150x140", "--spp", "4", "--denoise"};
  const ExrPicture whole = picture(large);
  const ExrPicture crop = picture(large + Words{"--crop", "20,10,140,130"});
  for (const std::string& name : kResults) {
    for (int y = 10 + kReach; y < 130 - kReach; ++y) {
      for (int x = 20 + kReach; x < 140 - kReach; ++x) {
        ASSERT_EQ(crop.at(name, x, y), whole.at(name, x, y)) << name << " at " << x << "," << y;
      }
    }
  }
}

TEST_F(Denoise, HalvesAddUpToThePicture) {
  for (const char* spp : {"2", "7", "16", "24"}) {
    const ExrPicture seen = picture({"--aov", "denoising", "--spp", spp});
    for (const char* c : {"R", "G", "B"}) {
      for (size_t i = 0; i < seen.channels.at(c).size(); ++i) {
        double sum = 0, count = 0;
        for (const std::string half : {"half1.", "half2."}) {
          const double n = double(seen.channels.at(half + "samples")[i]);
          EXPECT_GT(n, 0) << spp;
          sum += n * double(seen.channels.at(half + c)[i]);
          count += n;
        }
        EXPECT_EQ(count, std::stod(spp));
        const double whole = double(seen.channels.at(c)[i]);
        ASSERT_NEAR(sum / count, whole, 1e-6 * whole + 1e-9) << spp << ", " << c;
      }
    }
  }
}

TEST_F(Denoise, LightGroupsAddUp) {
  write_floats(path("grey.exr"), 8, 4, 3, std::vector<float>(8 * 4 * 3, 0.25f));
  const Words lights = {"--env", path("grey.exr"), "--light-groups"};
  const ExrPicture seen = picture(lights + kDenoised);
  for (const std::string layer : {"", "half1.", "half2.", "denoised."}) {
    for (const char* c : {"R", "G", "B"}) {
      const std::vector<float>& whole = seen.channels.at(layer + c);
      const std::vector<float>& lamp = seen.channels.at(layer + "light.lamp." + c);
      const std::vector<float>& sky = seen.channels.at(layer + "light.environment." + c);
      for (size_t i = 0; i < whole.size(); ++i) {
        ASSERT_NEAR(lamp[i] + sky[i], whole[i], 2e-5f * (std::abs(whole[i]) + 1e-3f))
            << layer << c << ", pixel " << i;
      }
    }
  }
  expect_within(picture(lights + Words{"--streams", "2"}), seen);
  render(words(lights + Words{"--aov", "denoising"}));
  expect_within(later(), seen);
}

// A PNG must show the denoised picture, whether `render` or `denoise` writes it.
TEST_F(Denoise, PicturesShowTheDenoisedResult) {
  render(words(kDenoised + Words{"-o", path("now.png"), "--transparent"}));
  const RunResult result = run({"denoise", path("out.exr"), "-o", path("later.png")});
  EXPECT_EQ(result.exit_code, 0) << result.describe();
  EXPECT_EQ(read_bytes(path("now.png")), read_bytes(path("later.png")));
  render({"render", scene(), "-o", path("alone.png"), "--spp", "16", "--size", "40x30", "--denoise",
          "--transparent"});
  EXPECT_EQ(read_bytes(path("alone.png")), read_bytes(path("now.png")));
  EXPECT_EQ(files(), (Words{"alone.png", "later.png", "now.png", "out.exr", "scene.glb"}));
}

TEST_F(Denoise, ReportHasTheGain) {
  render(words({"--denoise", "--report", path("r.json"), "--report", path("r.html")}));
  const nlohmann::json denoise = read_json("r.json")["denoise"];
  EXPECT_GT(denoise["error_before"].get<double>(), 0.0);
  EXPECT_GE(denoise["error_after"].get<double>(), 0.0);
  EXPECT_GE(denoise["kept_share"].get<double>(), 0.0);
  EXPECT_LE(denoise["kept_share"].get<double>(), 1.0);
  EXPECT_NE(text("r.html").find("denoised picture"), std::string::npos);
  render(words({"--report", path("r.json")}));
  EXPECT_TRUE(read_json("r.json")["denoise"].is_null());
}

TEST_F(Denoise, HeatmapsShowTheRemainingError) {
  const Words later = {"heatmap", path("out.exr"), "-o", path("map.exr"), "--of", "denoised_error"};
  const ExrPicture seen = picture({"--denoise"});
  EXPECT_EQ(run(later).exit_code, 0);
  EXPECT_EQ(read_exr(path("map.exr")).channels.at("denoised_error"),
            seen.channels.at("denoised.error"));
  expect_failure(words({"--denoise", "--heatmap", "m.png", "--heatmap-of", "denoised_error"}), 2,
                 {"--heatmap-of", "emberline heatmap"});
  render(words({"--aov", "denoising"}));
  expect_failure(later, 3, {"denoised.error", "--denoise"});
}

// The frame is stopped before every pixel has a sample. Denoising must not change the pixels
// without samples.
TEST_F(Denoise, PixelsWithoutSamplesAreUnchanged) {
  const ExrPicture seen = picture({"--size", "300x200", "--spp", "100000", "--driver", "bisection",
                                   "--time-limit", "0.001", "--denoise"});
  size_t bare = 0;
  for (size_t i = 0; i < seen.channels.at("samples").size(); ++i) {
    if (seen.channels.at("samples")[i] > 0) continue;
    ++bare;
    EXPECT_EQ(seen.channels.at("denoised.G")[i], seen.channels.at("G")[i]);
  }
  EXPECT_GT(bare, 1000u);
}

TEST_F(Denoise, PartsAreMergedAndDenoised) {
  const ExrPicture whole = picture({"--denoise", "--bucket-size", "16"});
  Words parts;
  for (const char* part : {"1", "2", "3"}) {
    render(words({"--denoise", "--bucket-size", "16", "--part", std::string(part) + "/3"}));
    parts.push_back(path("out.exr.part-" + std::string(part) + "-of-3.checkpoint"));
  }
  const RunResult result = run(Words{"merge", "-o", path("merged.exr")} + parts);
  EXPECT_EQ(result.exit_code, 0) << result.describe();
  expect_within(whole, read_exr(path("merged.exr")));
}

TEST_F(Denoise, ExtendedFrameEqualsADirectRender) {
  const ExrPicture straight = picture({"--denoise", "--spp", "48"});
  render(words({"--denoise", "--resumable"}));
  const RunResult result = run({"extend", path("out.exr"), "--spp", "48"});
  EXPECT_EQ(result.exit_code, 0) << result.describe();
  expect_within(straight, read_exr(path("out.exr")));
  render(words({"--denoise", "--resumable", "--spp", "8"}));
  expect_failure({"extend", path("out.exr"), "--spp", "48"}, 3, {"fewer than 16 samples"});
}

// Pixels with few samples must also have two halves, because otherwise the picture cannot be
// denoised.
TEST_F(Denoise, FewAdaptiveSamplesHaveTwoHalves) {
  const Words few = {"--denoise", "--spp", "8", "--report", path("r.json")};
  const ExrPicture even = picture(few + Words{"--driver", "bucket"});
  EXPECT_EQ(first_difference(even, picture(few + Words{"--driver", "adaptive"})), "");
  for (const Words& counts : {Words{"--spp", "11"}, Words{"--spp", "32", "--min-spp", "8"},
                              Words{"--noise-threshold", "0.01", "--max-spp", "8"}}) {
    picture(Words{"--driver", "adaptive", "--denoise", "--report", path("r.json")} + counts);
    const nlohmann::json json = read_json("r.json")["denoise"];
    EXPECT_LT(json["kept_share"].get<double>(), 0.5) << counts.back();
    EXPECT_LT(json["error_after"], json["error_before"]) << counts.back();
  }
}

TEST_F(Denoise, RejectsUnusableFiles) {
  expect_failure(words({"--denoise", "--streams", "1"}), 2, {"--denoise", "--streams"});
  expect_failure(words({"--denoise", "--integrator", "normal"}), 2, {"--denoise", "path"});
  render(words({"--aov", "albedo"}));
  const Words later = {"denoise", path("out.exr"), "-o", path("later.exr")};
  expect_failure(later, 3, {"out.exr", "half1.R", "--aov denoising"});
  expect_failure({"denoise", path("out.exr"), "-o", path("out.exr")}, 2,
                 {"-o", "the frame itself"});
  expect_failure({"denoise", path("out.exr"), "-o", path("later.tif")}, 2, {"-o", ".exr, .png"});
  expect_failure({"denoise", path("none.exr"), "-o", path("later.exr")}, 3, {"none.exr"});
  expect_failure({"denoise", scene(), "-o", path("later.exr")}, 3, {"not EXR"});
}

// Tests truncated files, flipped bytes, and numbers that are not finite.
TEST_F(Denoise, DamagedFilesGiveOneLineErrors) {
  render(words({"--aov", "denoising"}));
  const std::string whole = text("out.exr");
  const Words later = {"denoise", path("out.exr"), "-o", path("later.exr")};
  for (const size_t size : {size_t(0), size_t(100), whole.size() / 2}) {
    write("out.exr", whole.substr(0, size));
    expect_failure(later, 3, {"out.exr"});
  }
  expect_failure(later + Words{"--memory-limit", "1000"}, 3, {"out.exr"});
}

// The light is free of noise and far brighter than white. The expected error in the log and in the
// file must nevertheless be finite, and the frame must keep to the sample budget.
TEST_F(Denoise, BrightLightHasAnExpectedError) {
  const Words bright = {"--sun",    "30,0",      "--env-strength", "1e5", "--driver",
                        "adaptive", "--denoise", "--spp",          "64"};
  const RunResult result = render(words(bright));
  EXPECT_EQ(result.err.find("nan"), std::string::npos) << result.describe();
  const ExrPicture out = read_exr(path("out.exr"));
  double samples = 0;
  for (const float count : out.channels.at("samples")) samples += double(count);
  EXPECT_LE(samples / double(out.channels.at("samples").size()), 64.8);
  for (const float error : out.channels.at("denoised.error")) {
    ASSERT_TRUE(error >= 0 && error <= 0.5f) << error;
  }
}

}  // namespace
}  // namespace emberline::test
