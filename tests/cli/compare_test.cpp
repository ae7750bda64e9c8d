// Tests the output and the errors of `emberline compare`. tests/unit tests the metrics.
#include <cmath>
#include <nlohmann/json.hpp>

#include "cli/command_test.h"

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
