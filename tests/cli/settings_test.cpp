// Tests --settings and --save-settings, which read and write the settings of a frame as a file.
#include <sys/stat.h>

#include <nlohmann/json.hpp>

#include "cli/command_test.h"

namespace emberline::test {
namespace {

class SettingsFile : public CommandTest {
 protected:
  void expect_refused(const std::string& text, const Words& message_parts) {
    write("look.json", text);
    expect_failure(render_words({"--settings", path("look.json")}), 3,
                   Words{"look.json"} + message_parts);
  }
};

const Words kOptions = {
    "--driver",      "adaptive",     "--spp",           "9",           "--seed",    "4294967295",
    "--look-from",   "0.1,1.5,3.25", "--look-at",       "0,0.3,0",     "--fov-y",   "33.3",
    "--filter",      "gaussian",     "--filter-radius", "1.7",         "--sampler", "poisson_disk",
    "--crop",        "1,2,15,16",    "--env-strength",  "0.3",         "--env",     "sky.exr",
    "--transparent", "--aov",        "albedo,N",        "--backfaces", "show"};

TEST_F(SettingsFile, GivesTheSamePictureFromAnotherFolder) {
  write_floats(path("sky.exr"), 8, 4, 3, std::vector<float>(8 * 4 * 3, 0.5f));
  std::filesystem::create_directory(path("queue"));
  render(render_words(kOptions + Words{"--save-settings", path("queue/look.json")}));
  const ExrPicture asked = read_exr(path("out.exr"));
  RunOptions elsewhere;
  elsewhere.folder = path("queue");
  render({"render", scene(), "-o", path("again.exr"), "--settings", "look.json"}, elsewhere);
  const ExrPicture again = read_exr(path("again.exr"));
  EXPECT_EQ(first_difference(asked, again), "");
  EXPECT_EQ(again.attributes.at("emberline:seed"), "4294967295");
  EXPECT_EQ(again.attributes.at("emberline:filter_radius"), "1.7");
  EXPECT_EQ(read_json("queue/look.json")["env"], "../sky.exr");
  EXPECT_EQ(read_json("queue/look.json").count("max-depth"), 0u) << "is as it is by default";
}

TEST_F(SettingsFile, IsOverriddenByTheCommandLine) {
  write("look.json", R"({"spp": 3, "seed": 7, "transparent": true, "size": "8x8"})");
  for (const Words& words : {Words{"--settings", path("look.json"), "--spp", "2"},
                             Words{"--spp", "2", "--settings", path("look.json")}}) {
    render(Words{"render", scene(), "-o", path("out.exr")} + words);
    const ExrPicture picture = read_exr(path("out.exr"));
    EXPECT_EQ(picture.attributes.at("emberline:spp"), "2");
    EXPECT_EQ(picture.attributes.at("emberline:seed"), "7");
    EXPECT_EQ(picture.attributes.at("emberline:transparent"), "yes");
    EXPECT_EQ(picture.attributes.at("emberline:size"), "8x8");
  }
}

TEST_F(SettingsFile, ErrorsNameThePlace) {
  expect_refused("[]", {"expected"});
  expect_refused("{", {});
  expect_refused(R"({"sp": 2})", {"#/sp", "unknown setting 'sp' (did you mean 'spp',"});
  expect_refused(R"({"spp": 2, "spp": 3})", {"spp"});
  expect_refused(R"({"spp": 0})", {"#/spp", "'0'", "from 1 to 16777216"});
  expect_refused(R"({"spp": 1.5})", {"#/spp", "'1.5'"});
  expect_refused(R"({"spp": [2]})", {"#/spp", "expected a string, a number, true or false"});
  expect_refused(R"({"spp": null})", {"#/spp"});
  expect_refused(R"({"transparent": 1})", {"#/transparent", "yes or no"});
  expect_refused(R"({"sampler": "sobel"})", {"#/sampler", "did you mean 'sobol'"});
  expect_refused(R"({"size": "0x8"})", {"#/size", "65536"});
  expect_refused(R"({"look-from": "1,2,nan"})", {"#/look-from", "X,Y,Z"});
  expect_refused(R"({"env": ""})", {"#/env", "expected a string"});
  expect_refused(R"({"env": "a\u0000b"})", {"#/env", "without control characters"});
  expect_refused(R"({"scene": "x.glb"})", {"#/scene", "unknown setting"});
}

TEST_F(SettingsFile, IsNeitherOverwrittenNorReadFromAPipe) {
  write("look.json", R"({"spp": 2})");
  expect_failure(
      render_words({"--settings", path("look.json"), "--save-settings", path("look.json")}), 2,
      {"--save-settings", "look.json"});
  // A run that is refused must not write the file, and must leave an existing file unchanged.
  write("old.json", "old");
  for (const Words& wrong : {Words{"-o", path("no/a.png")}, Words{"--camera", "none"}}) {
    expect_failure(render_words(wrong + Words{"--save-settings", path("old.json")}),
                   wrong[0] == "-o" ? 1 : 2, {});
    EXPECT_EQ(read_text(path("old.json")), "old");
  }
  expect_failure(render_words({"--save-settings", scene()}), 2, {"--save-settings", "scene"});
  expect_failure(render_words({"--settings", path("no.json")}), 3, {"no.json"});
  ASSERT_EQ(mkfifo(path("pipe.json").c_str(), 0600), 0);
  expect_failure(render_words({"--settings", path("pipe.json")}), 3, {"pipe.json"});
}

}  // namespace
}  // namespace emberline::test
