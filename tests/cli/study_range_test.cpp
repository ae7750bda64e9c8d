// Tests `emberline study --frames`: the studies of the frames, and what is written about all.
#include <nlohmann/json.hpp>

#include "cli/study_fixture.h"
#include "support/animated_gltf.h"

namespace emberline::test {
namespace {

class StudyRange : public Study {
 protected:
  // The words of a study of a scene whose lamp moves.
  Words range_words(const std::string& folder, const std::string& frames, const Words& more = {}) {
    GltfBuilder gltf = lamp_scene();
    constexpr int kLamp = 2;  // the index of the lamp's node
    AnimationBuilder(gltf).move(kLamp, "translation", {0, 1}, "VEC3", {0, 0, 0, 0.5f, 0, 0.5f});
    const Words words = {"study",     gltf.write_glb(path("moving.glb")),
                         "-o",        path(folder),
                         "--fps",     "4",
                         "--spp",     "1,4",
                         "--size",    "24x16",
                         "--seeds",   "1",
                         "--drivers", "bucket,bisection",
                         "--frames",  frames};
    return words + more;
  }
  void copy(const std::string& from, const std::string& to) const {
    std::filesystem::copy_file(path(from), path(to));
  }
};

TEST_F(StudyRange, EachFrameHasItsStudyAndTheirResultsAreJoined) {
  const RunResult result = study(range_words("s", "3,1-2"));
  EXPECT_NE(result.out.find("Medians over 3 frames"), std::string::npos) << result.out;
  std::string joined;
  for (const std::string frame : {"1", "2", "3"}) {
    std::istringstream one(read_text(path("s/frame.000" + frame + "/study.csv")));
    std::string line;
    std::getline(one, line);
    if (frame == "1") joined = "frame," + line + "\n";
    while (std::getline(one, line)) joined += frame + "," + line + "\n";
  }
  EXPECT_EQ(read_text(path("s/range.csv")), joined);
  // Flicker must be what `compare` measures between the same pictures.
  for (const std::string frame : {"1", "2", "3"}) {
    const std::string pictures = "s/frame.000" + frame + "/pictures/";
    copy(pictures + "bisection-sobol.exr", "picture." + frame + ".exr");
    copy(pictures + "reference.exr", "reference." + frame + ".exr");
  }
  const RunResult compared =
      run({"compare", path("picture.#.exr"), path("reference.#.exr"), "--json"});
  ASSERT_EQ(compared.exit_code, 0) << compared.describe();
  EXPECT_EQ(compared.err.find("no layer velocity"), std::string::npos);
  const nlohmann::json expected = nlohmann::json::parse(compared.out)["frames"];
  const nlohmann::json range = read_json("s/range.json");
  ASSERT_EQ(range["frames"].size(), 3u);
  for (size_t i = 0; i < 3; ++i) {
    const nlohmann::json& frame = range["frames"][i];
    EXPECT_EQ(frame["frame"], i + 1);
    EXPECT_EQ(frame["folder"], "frame.000" + std::to_string(i + 1));
    const nlohmann::json& method = frame["methods"][1];
    EXPECT_EQ(method["method"], "bisection");
    EXPECT_GT(method["relmse_trimmed"].get<double>(), 0);
    if (i == 2) {
      EXPECT_TRUE(method["flicker"].is_null());
    } else {
      const double flicker = expected[i]["flicker"];
      EXPECT_NEAR(method["flicker"].get<double>(), flicker, 1e-4 * flicker);
    }
  }
  EXPECT_EQ(range["frames"][0]["methods"][0]["speedup"], 1);
  const nlohmann::json& summary = range["summary"][1]["relmse_trimmed"];
  EXPECT_LE(summary["least"], summary["median"]);
  EXPECT_LE(summary["median"], summary["largest"]);
  const std::string page = read_text(path("s/range.html"));
  for (const char* part : {"frame.0002/study.html", "Flicker until the next frame", "bisection"}) {
    EXPECT_NE(page.find(part), std::string::npos) << part;
  }
  // Frames differ in their pictures, not only in their noise.
  EXPECT_NE(first_difference(read_exr(path("reference.1.exr")), read_exr(path("reference.3.exr"))),
            "");
}

TEST_F(StudyRange, GoesOnWithFurtherFrames) {
  study(range_words("s", "1"));
  const std::string run = "s/frame.0001/runs/bucket-sobol_0.json";
  const auto written = std::filesystem::last_write_time(path(run));
  study(range_words("s", "1,5"));
  EXPECT_EQ(std::filesystem::last_write_time(path(run)), written);
  const nlohmann::json range = read_json("s/range.json");
  ASSERT_EQ(range["frames"].size(), 2u);
  EXPECT_EQ(range["frames"][1]["frame"], 5);
  // There is no frame 2, so nothing is known about flicker.
  EXPECT_TRUE(range["frames"][0]["methods"][0]["flicker"].is_null());
  EXPECT_TRUE(range["summary"][0]["flicker"].is_null());
}

TEST_F(StudyRange, AnEntireTurntable) {
  study({"study", scene(), "-o", path("s"), "--size", "16x16", "--spp", "2", "--seeds", "1",
         "--drivers", "bucket", "--turntable", "2"});
  const nlohmann::json range = read_json("s/range.json");
  ASSERT_EQ(range["frames"].size(), 2u);
  EXPECT_GT(range["frames"][0]["methods"][0]["flicker"].get<double>(), 0);
}

TEST_F(StudyRange, EachFrameHasItsReference) {
  for (const char* frame : {"1", "2"}) {
    const RunResult rendered = run({"render", scene(), "--size", "24x16", "--spp", "64", "-o",
                                    path(std::string("r.") + frame + ".exr"), "--quiet"});
    ASSERT_EQ(rendered.exit_code, 0) << rendered.describe();
  }
  study(range_words("s", "1-2", {"--reference", path("r.#.exr")}));
  EXPECT_EQ(read_json("s/frame.0002/study.json")["reference"]["file"], path("r.2.exr"));
  expect_failure(range_words("t", "1-3", {"--reference", path("r.#.exr")}), 3, {path("r.3.exr")});
}

TEST_F(StudyRange, WrongRanges) {
  expect_failure(range_words("s", "1-2", {"--frame", "3"}), 2, {"--frames", "--frame"});
  expect_failure(range_words("s", "1-"), 2, {"--frames", "1-"});
  expect_failure({"study", "--convergence", "--frames", "1-2"}, 2, {"--convergence", "--frames"});
  EXPECT_FALSE(exists("s"));
  write("foreign/range.csv", "irreplaceable");
  expect_failure(range_words("foreign", "1"), 2, {path("foreign"), "emberline-study-range.json"});
  // The folder may come from someone else, and a link could lead anywhere.
  study(range_words("linked", "1"));
  std::filesystem::create_directory(path("elsewhere"));
  std::filesystem::create_symlink(path("elsewhere"), path("linked/frame.0002"));
  expect_failure(range_words("linked", "1-2"), 2, {path("linked/frame.0002"), "symbolic link"});
  // A range does not go into the folder of a single study, nor the other way round.
  study(study_words("one", {"--drivers", "bucket"}));
  expect_failure(range_words("one", "1"), 2, {path("one")});
  study(range_words("many", "1"));
  expect_failure(study_words("many"), 2, {path("many")});
}

}  // namespace
}  // namespace emberline::test
