// Tests --report FILE.html. The page must be well-formed for any text, and it must have the values
// of the JSON report, even if the render was stopped.

#include <csignal>
#include <nlohmann/json.hpp>

#include "cli/command_test.h"
#include "support/markup.h"

namespace emberline::test {
namespace {

class ReportPage : public CommandTest {
 protected:
  ParsedMarkup page(const std::string& name = "r.html") const {
    ParsedMarkup read = read_markup(read_text(path(name)));
    EXPECT_EQ(read.fault, "");
    EXPECT_EQ(read.count("script") + read.count("link"), 0u);
    for (const Element& element : read.elements) {
      if (element.name != "img") continue;
      EXPECT_TRUE(element.attributes.at("src").starts_with("data:image/")) << element.name;
      EXPECT_FALSE(element.attributes.at("alt").empty());
    }
    return read;
  }
  static void expect_text(const ParsedMarkup& read, const std::string& text) {
    EXPECT_NE(read.text.find(text), std::string::npos) << "not on the page: " << text;
  }
};

std::string grouped(uint64_t count) {
  std::string text = std::to_string(count);
  for (size_t i = text.size(); i > 3; i -= 3) text.insert(i - 3, 1, ',');
  return text;
}

TEST_F(ReportPage, MatchesTheJsonForEveryDriver) {
  for (const char* driver : {"bucket", "bisection", "adaptive"}) {
    SCOPED_TRACE(driver);
    render(render_words({"--driver", driver, "--size", "40x24", "--spp", "16", "--report",
                         path("r.json"), "--report", path("r.html")}));
    const nlohmann::json json = read_json("r.json");
    const ParsedMarkup read = page();
    for (const char* count : {"/samples/total", "/samples/min", "/samples/max", "/rays/camera",
                              "/rays/scatter", "/rays/shadow", "/rays/total"}) {
      expect_text(read, grouped(json.at(nlohmann::json::json_pointer(count)).get<uint64_t>()));
    }
    for (const auto& feature : json["features"]) expect_text(read, feature);
    for (const auto& [name, version] : json["versions"].items()) expect_text(read, version);
    expect_text(read, json["settings"]["command"]);
    EXPECT_GE(read.count("img"), 2u);  // the picture and the sample counts
    // Only adaptive frames have charts, because only they have varying counts and an estimate.
    const bool adaptive = json["samples"]["min"] != json["samples"]["max"];
    EXPECT_EQ(read.count("svg"), adaptive ? 2u : 0u);
  }
}

TEST_F(ReportPage, HasAMapForEachChannel) {
  render(render_words({"--report", path("a.html")}));
  render(render_words({"--aov", "variance,time,stop", "--spp", "4", "--report", path("b.html")}));
  EXPECT_EQ(page("b.html").count("img"), page("a.html").count("img") + 3);
}

// The page must show estimated and true errors over time if both are known.
TEST_F(ReportPage, ErrorAgainstTime) {
  render(render_words({"--size", "48x32", "--spp", "64", "-o", path("reference.exr")}));
  render(render_words({"--size", "48x32", "--spp", "16", "--driver", "adaptive", "--seed", "3",
                       "--snapshots", path("shots"), "--snapshot-at", "first,8spp,15spp",
                       "--reference", path("reference.exr"), "--report", path("r.html"), "--report",
                       path("r.json")}));
  const ParsedMarkup read = page();
  EXPECT_EQ(read.count("polyline"), 2u);
  expect_text(read, "measured against the reference");
  const auto report = read_json("r.json");
  for (const auto& snapshot : report["snapshots"]) expect_text(read, snapshot["file"]);
}

TEST_F(ReportPage, OddNamesAreEscaped) {
  for (const std::string name : {"a<b>&\"c\".glb", "it's </title><script>.glb", "Küche 場面.glb",
                                 "new\nline.glb", "no \xff utf-8.glb"}) {
    SCOPED_TRACE(name);
    GltfBuilder gltf = lamp_scene();
    gltf.root["cameras"][0]["name"] = "<i>&amp;";
    gltf.root["nodes"].back()["name"] = "<i>&amp;";
    gltf.write_glb(path("scene.glb"));
    const std::string odd = path(name);
    std::error_code error;
    std::filesystem::create_directories(std::filesystem::path(odd).parent_path(), error);
    std::filesystem::copy_file(path("scene.glb"), odd, error);
    ASSERT_FALSE(error) << error.message();
    render({"render", odd, "-o", path("out.exr"), "--size", "16x16", "--spp", "1", "--report",
            path("r.html")});
    const ParsedMarkup read = page();
    EXPECT_EQ(read.count("b") + read.count("i"), 0u);
    const auto seen = std::filesystem::path(odd).filename().string();
    if (seen.find('\xff') == std::string::npos) expect_text(read, seen);
    std::filesystem::remove(odd);
  }
}

// If a shell runs the command that the page shows, the command must render the same picture.
TEST_F(ReportPage, CommandOnThePageRepeatsTheRender) {
  for (const std::string odd : {"it's a \"scene\" & $HOME `x` \\.glb", "line\nand \xff.glb"}) {
    SCOPED_TRACE(odd);
    lamp_scene().write_glb(path(odd));
    render({"render", path(odd), "-o", path("out.exr"), "--size", "24x16", "--spp", "3", "--seed",
            "7", "--report", path("r.html")});
    const ParsedMarkup read = page();
    const size_t begin = read.text.find("emberline render");
    ASSERT_NE(begin, std::string::npos);
    std::string command = read.text.substr(begin, read.text.find('\n', begin) - begin);
    const ExrPicture first = read_exr(path("out.exr"));
    std::filesystem::remove(path("out.exr"));
    command.replace(0, std::string("emberline").size(), EMBERLINE_BINARY);
    ASSERT_EQ(std::system((command + " 2>/dev/null").c_str()), 0) << command;
    EXPECT_EQ(first_difference(read_exr(path("out.exr")), first), "");
  }
}

TEST_F(ReportPage, IsWrittenForAStoppedRender) {
  Process process({"render", scene(), "-o", path("out.exr"), "--size", "256x256", "--spp", "4096",
                   "--verbose", "--bucket-size", "16", "--report", path("r.html")},
                  {.folder = folder_.path()});
  ASSERT_TRUE(process.wait_until_busy("loaded in", 0.2 * kSanitizerSlowdown))
      << process.error_so_far();
  process.send(SIGINT);
  ASSERT_EQ(process.wait().exit_code, 130);
  const ParsedMarkup read = page();
  expect_text(read, "The user stopped the render");
  expect_text(read, "Pixels have 0 to ");

  render(render_words({"--driver", "adaptive", "--size", "256x256", "--spp", "65536",
                       "--time-limit", "0.1", "--report", path("limit.html")}));
  expect_text(page("limit.html"), "The time limit stopped the render");
}

// The frame is far larger than its film in memory, because each bucket is written and released. The
// data that the page keeps of a frame must not grow with the frame either.
TEST_F(ReportPage, DoesNotGrowWithTheFrame) {
  if (kSanitized) GTEST_SKIP() << "a sanitizer's own memory is many times ours";
  const RunResult result =
      render(render_words({"--size", "3600x2400", "--integrator", "albedo", "--quiet", "--report",
                           path("r.json"), "--report", path("r.html")}));
  const nlohmann::json json = read_json("r.json");
  const double peak = json["memory"]["peak_rss_bytes"];
  EXPECT_LT(peak, 130e6);  // as floats, RGBA and samples of the whole frame would need 173 MB
  EXPECT_LE(peak, 1.02 * double(result.peak_rss_bytes));
  EXPECT_LT(json["memory"]["film_bytes"].get<double>(), 50e6);
  EXPECT_EQ(json["samples"]["total"], 3600 * 2400);
  const ParsedMarkup read = page();
  expect_text(read, "Each pixel here is the mean of 3 x 3 pixels of the frame.");
  const auto image = std::ranges::find(read.elements, "img", &Element::name);
  EXPECT_EQ(image->attributes.at("width"), "1200");
  EXPECT_EQ(image->attributes.at("height"), "800");
}

TEST_F(ReportPage, NothingIsWrittenForAnUnknownView) {
  expect_failure(render_words({"--report", path("r.html"), "--view", "none such"}), 2,
                 {"none such"});
}

}  // namespace
}  // namespace emberline::test
