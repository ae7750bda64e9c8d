// Tests the output and the errors of `emberline compare`. tests/unit tests the metrics.
#include <filesystem>
#include <nlohmann/json.hpp>
#include <tuple>

#include "cli/command_test.h"
#include "io/exr/writer.h"

namespace emberline::test {
namespace {

class Compare : public CommandTest {
 protected:
  void SetUp() override {
    write_floats(path("a.exr"), 24, 16, 3, std::vector<float>(24 * 16 * 3, 0.5f));
    write_floats(path("b.exr"), 24, 16, 3, std::vector<float>(24 * 16 * 3, 0.4f));
    write_floats(path("small.exr"), 8, 8, 3, std::vector<float>(8 * 8 * 3, 0.4f));
    write_floats(path("depth.exr"), 24, 16, 1, std::vector<float>(24 * 16, 0.4f));
  }
};

TEST_F(Compare, Json) {
  const RunResult result = run({"compare", path("a.exr"), path("b.exr"), "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.describe();
  EXPECT_EQ(result.err, "");
  const nlohmann::json json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json["width"], 24);
  EXPECT_EQ(json["height"], 16);
  EXPECT_NEAR(json["mse"].get<double>(), 0.01, 1e-7);
  EXPECT_NEAR(json["rmse"].get<double>(), 0.1, 1e-6);
  EXPECT_NEAR(json["signed_bias"].get<double>(), 0.25, 1e-6);
  EXPECT_NEAR(json["max_abs"].get<double>(), 0.1, 1e-6);
  EXPECT_EQ(json["different_pixels"], 24 * 16);
  for (const char* key : {"relmse", "relmse_trimmed", "psnr", "ssim", "flip"}) {
    EXPECT_TRUE(json[key].is_number()) << key;
  }
}

TEST_F(Compare, TableAndEqualPictures) {
  const RunResult result = run({"compare", path("a.exr"), path("a.exr")});
  ASSERT_EQ(result.exit_code, 0) << result.describe();
  for (const char* key : {"mse", "relmse_trimmed", "signed_bias", "psnr", "ssim", "flip"}) {
    EXPECT_NE(result.out.find(key), std::string::npos) << result.out;
  }
  const nlohmann::json json =
      nlohmann::json::parse(run({"compare", path("a.exr"), path("a.exr"), "--json"}).out);
  EXPECT_EQ(json["mse"], 0.0);
  EXPECT_EQ(json["different_pixels"], 0);
  EXPECT_TRUE(json["psnr"].is_null());
}

TEST_F(Compare, DifferencePictures) {
  for (const char* name : {"d.png", "d.jpg", "d.exr"}) {
    const RunResult result = run({"compare", path("a.exr"), path("b.exr"), "-o", path(name)});
    EXPECT_EQ(result.exit_code, 0) << result.describe();
  }
  EXPECT_EQ(read_bytes_picture(path("d.png")).width, 24);
  const ExrPicture difference = read_exr(path("d.exr"));
  EXPECT_EQ(difference.at("R", 3, 3), 0.5f - 0.4f);
  EXPECT_TRUE(difference.types.contains("flip"));
}

TEST_F(Compare, OwnFramesCanBeCompared) {
  render(render_words({"--seed", "1", "-o", path("f.png"), "--aov", "N,id"}));
  const nlohmann::json json =
      nlohmann::json::parse(run({"compare", path("out.exr"), path("out.exr"), "--json"}).out);
  EXPECT_EQ(json["mse"], 0.0);
  // The PNG has the same picture, but it is clipped at white and quantised to 8 bits.
  const nlohmann::json png =
      nlohmann::json::parse(run({"compare", path("f.png"), path("out.exr"), "--json"}).out);
  EXPECT_GT(png["psnr"].get<double>(), 40.0);
}

// Frames 8 to 11 of one sequence and 7 to 10 and 12 of the other, whose errors are known.
class CompareSequence : public Compare {
 protected:
  void SetUp() override {
    Compare::SetUp();
    std::filesystem::create_directory(path("shot"));
    for (int frame = 8; frame <= 11; ++frame)
      write_grey(picture("a", frame), 1 + 0.1f * float(frame - 8));
    for (const int frame : {7, 8, 9, 10, 12}) write_grey(picture("r", frame), 1);
    for (const char* other :
         {"shot/a.9.exr", "shot/a.0009.png", "shot/a.x.exr", "shot/b.0009.exr"}) {
      write(other, "not read");
    }
  }
  static void write_grey(const std::string& file, float value) {
    write_floats(file, 24, 16, 3, std::vector<float>(24 * 16 * 3, value));
  }
  std::string picture(const char* name, int frame) const {
    return path("shot/" + std::string(name) + (frame < 10 ? ".000" : ".00") +
                std::to_string(frame) + ".exr");
  }
  Words words(const Words& more = {}) const {
    return Words{"compare", path("shot/a.####.exr"), path("shot/r.####.exr")} + more;
  }
};

TEST_F(CompareSequence, MeasuresTheFramesThatBothHave) {
  const RunResult result = run(words({"--json", "--chart", path("error.svg")}));
  ASSERT_EQ(result.exit_code, 0) << result.describe();
  EXPECT_NE(result.err.find("left out: 11"), std::string::npos) << result.err;
  const nlohmann::json json = nlohmann::json::parse(result.out), &frames = json["frames"];
  ASSERT_EQ(frames.size(), 3u);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(frames[i]["frame"], 8 + i);
    EXPECT_NEAR(frames[i]["mse"].get<double>(), 0.01 * i * i, 1e-6);
  }
  // Each error is .1 larger than the one before; epsilon is 1 % of the reference's square.
  EXPECT_NEAR(frames[0]["flicker"].get<double>(), 0.01 / 1.01, 1e-6);
  EXPECT_NEAR(frames[1]["flicker"].get<double>(), 0.01 / 1.01, 1e-6);
  EXPECT_EQ(frames[0]["flicker_share"], 1.0);
  EXPECT_TRUE(frames[2]["flicker"].is_null());
  const nlohmann::json& relmse = json["summary"]["relmse"];
  EXPECT_NEAR(relmse["median"].get<double>(), 0.01 / 1.01, 1e-6);
  EXPECT_NEAR(relmse["mean"].get<double>(), 0.05 / 3 / 1.01, 1e-6);
  EXPECT_NEAR(relmse["largest"].get<double>(), 0.04 / 1.01, 1e-6);
  const std::string chart = read_text(path("error.svg"));
  EXPECT_TRUE(chart.starts_with("<svg")) << chart.substr(0, 80);
  EXPECT_NE(chart.find("flicker"), std::string::npos);
}

TEST_F(CompareSequence, TableAndDifferencePictures) {
  const RunResult result = run(words({"-o", path("d.##.exr")}));
  ASSERT_EQ(result.exit_code, 0) << result.describe();
  for (const char* word : {"frame", "flicker", "median", "largest", "0.00990099"}) {
    EXPECT_NE(result.out.find(word), std::string::npos) << word << result.out;
  }
  EXPECT_NEAR(read_exr(path("d.10.exr")).at("R", 3, 3), 0.2f, 1e-6f);
  EXPECT_FALSE(std::filesystem::exists(path("d.11.exr")));
}

// A gap in the sequence is not a step from frame to frame.
TEST_F(CompareSequence, OneReferenceForAllAndGaps) {
  std::filesystem::remove(picture("a", 9));
  const RunResult result = run({"compare", path("shot/a.####.exr"), picture("r", 12), "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.describe();
  const nlohmann::json frames = nlohmann::json::parse(result.out)["frames"];
  ASSERT_EQ(frames.size(), 3u);
  EXPECT_TRUE(frames[0]["flicker"].is_null());
  EXPECT_TRUE(frames[1]["flicker"].is_number());
}

// An error moves 3 pixels to the right and 2 up, as `velocity` says, and not as its opposite says.
// A crop of the picture takes the motion of its own pixels.
TEST_F(CompareSequence, FollowsVelocity) {
  constexpr int kWidth = 24, kHeight = 16;
  const auto write_frame = [&](const std::string& name, const Rect& window, int x, int y,
                               float up) {
    const ExrHeader header = {.width = kWidth,
                              .height = kHeight,
                              .data_window = window,
                              .channels = {{"R"}, {"G"}, {"B"}, {"velocity.X"}, {"velocity.Y"}},
                              .attributes = {}};
    std::vector<float> pixels;
    for (size_t i = 0; i < size_t(window.area()); ++i) {
      const float value = window.x_of(i) == x && window.y_of(i) == y ? 2 : 1;
      // Only the lower half of the frame moves.
      const bool moves = window.y_of(i) >= kHeight / 2;
      pixels.insert(pixels.end(), {value, value, value, moves ? 3.0f : 0, moves ? up : 0});
    }
    write_exr_file(path(name), header, pixels);
  };
  const auto flicker = [&](const char* image, const char* reference) {
    const RunResult result = run({"compare", path(image), path(reference), "--json"});
    EXPECT_EQ(result.exit_code, 0) << result.describe();
    return nlohmann::json::parse(result.out)["frames"][0]["flicker"].get<double>();
  };
  const Rect whole = {0, 0, kWidth, kHeight}, part = {6, 4, 22, 16};
  for (const auto& [number, x, y] : {std::tuple{"1", 10, 13}, {"2", 13, 11}}) {
    const std::string end = std::string(number) + ".exr";
    write_frame("moved." + end, whole, x, y, 2);
    write_frame("part." + end, part, x, y, 0);
    write_frame("up." + end, whole, -1, -1, 2);
    write_frame("down." + end, whole, -1, -1, -2);
  }
  EXPECT_EQ(flicker("moved.#.exr", "up.#.exr"), 0);
  EXPECT_GT(flicker("moved.#.exr", "down.#.exr"), 0.001);
  EXPECT_EQ(flicker("part.#.exr", "up.#.exr"), 0);
  EXPECT_GT(flicker("part.#.exr", "down.#.exr"), 0.001);
}

// No output may replace a picture that is compared, whichever frame it belongs to.
TEST_F(CompareSequence, KeepsItsInputs) {
  std::filesystem::remove(picture("a", 11));  // so that the log has only the error
  const Words own = {"compare", path("shot/a.####.exr"), path("shot/r.####.exr")};
  expect_failure(own + Words{"-o", path("shot/a.####.exr")}, 2, {"a.0008.exr", "compared"});
  expect_failure(own + Words{"-o", path("shot/r.00##.exr")}, 2, {"r.0008.exr", "compared"});
  expect_failure(
      {"compare", path("shot/a.####.exr"), picture("r", 9), "-o", path("shot/r.####.exr")}, 2,
      {"r.0009.exr", "compared"});
  std::filesystem::create_hard_link(picture("a", 9), path("chart.svg"));
  expect_failure(own + Words{"--chart", path("chart.svg")}, 2, {"chart.svg", "compared"});
  expect_failure(own + Words{"--chart", path("none/c.svg")}, 1, {"none/c.svg"});
  expect_failure(own + Words{"--chart", path("c.png")}, 2, {"c.png", ".svg"});
}

// A frame of another size is measured, but has no flicker.
TEST_F(CompareSequence, AFrameOfAnotherSize) {
  for (const char* name : {"a", "r"}) {
    write_floats(picture(name, 9), 8, 8, 3, std::vector<float>(8 * 8 * 3, 1));
  }
  const RunResult result = run(words({"--json"}));
  ASSERT_EQ(result.exit_code, 0) << result.describe();
  EXPECT_NE(result.err.find("a.0009.exr: flicker is not measured"), std::string::npos)
      << result.err;
  const nlohmann::json frames = nlohmann::json::parse(result.out)["frames"];
  ASSERT_EQ(frames.size(), 3u);
  EXPECT_EQ(frames[1]["width"], 8);
  for (const nlohmann::json& frame : frames) EXPECT_TRUE(frame["flicker"].is_null());
}

TEST_F(CompareSequence, RejectsWhatIsNoSequence) {
  expect_failure({"compare", path("shot/x.####.exr"), path("a.exr")}, 3, {"x.####.exr", "no file"});
  expect_failure({"compare", path("shot/a.####.exr"), path("gone/r.####.exr")}, 3,
                 {"gone/r.####.exr"});
  expect_failure({"compare", path("a.exr"), path("shot/r.####.exr")}, 2, {"r.####.exr", "a.exr"});
  expect_failure({"compare", path("#/a.exr"), path("a.exr")}, 2, {"folder"});
  expect_failure({"compare", path("a.exr"), path("b.exr"), "--chart", path("c.svg")}, 2,
                 {"--chart"});
  expect_failure(words({"-o", path("d.png")}), 2, {"d.png", "####"});
  std::filesystem::remove(picture("a", 11));
  write_floats(picture("a", 9), 8, 8, 3, std::vector<float>(8 * 8 * 3, 1));
  expect_failure(words(), 3, {"0009.exr", "8 x 8"});
  std::filesystem::remove(picture("r", 8));
  std::filesystem::remove(picture("r", 9));
  std::filesystem::remove(picture("r", 10));
  expect_failure(words(), 3, {"r.####.exr", "no frame"});
}

TEST_F(Compare, RejectsIncomparablePictures) {
  const std::string a = path("a.exr"), b = path("b.exr");
  expect_failure({"compare", a, path("small.exr")}, 3, {"a.exr", "24 x 16", "8 x 8"});
  expect_failure({"compare", a, path("missing.exr")}, 3, {"missing.exr"});
  expect_failure({"compare", path("missing.exr"), b, "-o", path("d.exr")}, 3, {"missing.exr"});
  expect_failure({"compare", a, path("depth.exr")}, 3, {"depth.exr", "R, G and B"});
  write("text.exr", "no picture");
  expect_failure({"compare", a, path("text.exr")}, 3, {"text.exr"});
  expect_failure({"compare", a, b, "-o", path("d.tif")}, 2, {"d.tif", ".exr, .png, .jpg"});
  expect_failure({"compare", a, b, "--exposure", "nan"}, 2, {"--exposure", "-64 to 64"});
  expect_failure({"compare", a, b, "-o", path("missing/d.png")}, 1, {"missing/d.png"});
}

}  // namespace
}  // namespace emberline::test
