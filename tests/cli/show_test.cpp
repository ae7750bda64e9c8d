// Tests `emberline show`, the layers of `compare`, and `emberline info` for frames.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "cli/command_test.h"
#include "io/exr/writer.h"

namespace emberline::test {
namespace {

class Show : public CommandTest {
 protected:
  // Runs `emberline show` on out.exr.
  RunResult show(const std::string& name, const Words& more = {}) {
    const RunResult result = run(Words{"show", path("out.exr"), "-o", path(name)} + more);
    EXPECT_EQ(result.exit_code, 0) << result.describe();
    EXPECT_EQ(result.out, "");
    return result;
  }
  // Writes out.exr with two equal pixels, as another program would write it.
  void write_pixel(const std::vector<PictureChannel>& channels, const std::vector<float>& values) {
    std::vector<float> pixels = values;
    pixels.insert(pixels.end(), values.begin(), values.end());
    write_exr_file(path("out.exr"),
                   {.width = 2,
                    .height = 1,
                    .data_window = {0, 0, 2, 1},
                    .channels = channels,
                    .attributes = {}},
                   pixels);
  }
  std::vector<int> first_pixel(const std::string& name) {
    const BytePicture picture = read_bytes_picture(path(name));
    return {picture.at(0, 0), picture.at(0, 0) + picture.channels};
  }
  nlohmann::json info() {
    const RunResult result = run({"info", path("out.exr"), "--json"});
    EXPECT_EQ(result.exit_code, 0) << result.describe();
    return nlohmann::json::parse(result.out);
  }
};

TEST_F(Show, WritesThePictureThatTheRenderWrites) {
  const Words cases[] = {{},
                         {"--view", "ACES", "--exposure", "-1.5"},
                         {"--transparent", "--view", "Raw"},
                         {"--working-space", "acescg"},
                         {"--crop", "3,2,13,11", "--bucket-size", "5"},
                         {"--exr-parts", "layers", "--aov", "albedo,depth_variance"}};
  for (const Words& options : cases) {
    SCOPED_TRACE(testing::PrintToString(options));
    render(render_words(Words{"-o", path("a.png"), "-o", path("a.jpg"), "--spp", "4"} + options));
    const bool has_view = std::ranges::count(options, "--view") > 0;
    Words display;
    for (size_t i = 0; has_view && i + 1 < options.size(); ++i) {
      if (options[i] == "--view" || options[i] == "--exposure") {
        display = display + Words{options[i], options[i + 1]};
      }
    }
    show("b.png", display + Words{"-o", path("b.jpg")});
    EXPECT_EQ(read_bytes(path("a.png")), read_bytes(path("b.png")));
    EXPECT_EQ(read_bytes(path("a.jpg")), read_bytes(path("b.jpg")));
  }
}

TEST_F(Show, TheDenoisedLayerIsThePictureOfTheRender) {
  render(render_words(
      {"--denoise", "--spp", "16", "--size", "40x30", "-o", path("a.png"), "--transparent"}));
  EXPECT_EQ(show("b.png", {"--layer", "denoised"}).err.find("--layer"), std::string::npos);
  EXPECT_EQ(read_bytes(path("a.png")), read_bytes(path("b.png")));
  const RunResult raw = show("c.png");
  EXPECT_NE(raw.err.find("--layer denoised"), std::string::npos) << raw.err;
  EXPECT_NE(read_bytes(path("a.png")), read_bytes(path("c.png")));
}

TEST_F(Show, AlphaIsThatOfTheFile) {
  write_pixel({{"R"}, {"G"}, {"B"}}, {0.0f, 1.0f, 0.2f});
  show("a.png", {"--view", "Raw"});
  EXPECT_EQ(first_pixel("a.png"), (std::vector<int>{0, 255, 51}));
  write_pixel({{"R"}, {"G"}, {"B"}, {"A"}}, {0.0f, 0.4f, 0.1f, 0.4f});
  show("a.png", {"--view", "Raw"});
  // The colours of a PNG are not multiplied by alpha.
  EXPECT_EQ(first_pixel("a.png"), (std::vector<int>{0, 255, 64, 102}));
  show("a.jpg", {"--view", "Raw"});
  EXPECT_EQ(read_bytes_picture(path("a.jpg")).channels, 3);
}

TEST_F(Show, AnExrHasTheLayerAlone) {
  render(render_words({"--aov", "albedo,N", "--crop", "3,2,13,11"}));
  show("albedo.exr", {"--layer", "albedo", "--exposure", "3"});
  const ExrPicture frame = read_exr(path("out.exr")), albedo = read_exr(path("albedo.exr"));
  EXPECT_EQ(albedo.data, frame.data);
  EXPECT_EQ(albedo.display, frame.display);
  ASSERT_EQ(albedo.channels.size(), 3u);
  for (const char* c : {"R", "G", "B"}) {
    EXPECT_EQ(albedo.channels.at(c), frame.channels.at(std::string("albedo.") + c)) << c;
  }
  show("normal.exr", {"--layer", "N"});
  EXPECT_EQ(read_exr(path("normal.exr")).channels.at("G"), frame.channels.at("N.Y"));
  show("one.exr", {"--layer", "albedo.G"});
  EXPECT_EQ(read_exr(path("one.exr")).channels.at("B"), frame.channels.at("albedo.G"));
  show("all.exr");
  EXPECT_EQ(read_exr(path("all.exr")).channels.at("A"), frame.channels.at("A"));
}

TEST_F(Show, NumbersAreGreyFromTheLeastToTheGreatest) {
  write_exr_file(path("out.exr"),
                 {.width = 4,
                  .height = 1,
                  .data_window = {0, 0, 4, 1},
                  .channels = {{"R"}, {"G"}, {"B"}, {"Z"}, {"mask"}},
                  .attributes = {}},
                 std::vector<float>{0, 0, 0, 2, 0.2f, 0, 0, 0, 4,     0.2f,
                                    0, 0, 0, 7, 0.2f, 0, 0, 0, 1e10f, 0.2f});
  const RunResult result = show("z.png", {"--layer", "Z", "--view", "Raw"});
  EXPECT_NE(result.err.find("Z: black is 2, white is 7"), std::string::npos) << result.err;
  const BytePicture depth = read_bytes_picture(path("z.png"));
  const int wanted[] = {0, 102, 255, 255};
  for (int x = 0; x < 4; ++x) EXPECT_EQ(depth.at(x, 0)[1], wanted[x]) << x;
  show("m.png", {"--layer", "mask", "--view", "Raw"});
  EXPECT_EQ(first_pixel("m.png"), (std::vector<int>{51, 51, 51}));
}

TEST_F(Show, CountsNameTheirHeatmap) {
  render(render_words({"--aov", "rays"}));
  for (const char* name : {"samples", "rays.shadow"}) {
    const std::string command = std::string("a.png --of ") + name;
    EXPECT_NE(show("a.png", {"--layer", name}).err.find(command), std::string::npos) << name;
    EXPECT_EQ(show("a.exr", {"--layer", name}).err.find("heatmap"), std::string::npos) << name;
  }
}

// A file has a table with an entry for each tile. If the tiles of the input are tiny, the output
// must have larger tiles.
TEST_F(Show, TilesOfOnePixelBecomeLargerOnes) {
  render(render_words({"--bucket-size", "1"}));
  show("a.exr");
  EXPECT_EQ(read_exr(path("a.exr")).channels.at("R"), read_exr(path("out.exr")).channels.at("R"));
  EXPECT_LT(std::filesystem::file_size(path("a.exr")), std::filesystem::file_size(path("out.exr")));
}

TEST_F(Show, UnknownLayersListWhatThereIsNearestFirst) {
  render(render_words({"--aov", "albedo,N,velocity,Z"}));
  for (const char* command : {"show", "compare"}) {
    Words words = {command, path("out.exr")};
    words = words + (words[0] == "show" ? Words{"-o", path("a.png")} : Words{path("out.exr")});
    expect_failure(words + Words{"--layer", "P"}, 2, {"out.exr has no P; render it with --aov P"});
    expect_failure(words + Words{"--layer", "denoised"}, 2, {"render it with --denoise"});
    expect_failure(words + Words{"--layer", "albdo"}, 2,
                   {"--layer", "unknown layer 'albdo'", "closest match first, are albedo, ",
                    "velocity", "RGBA", "samples"});
  }
}

TEST_F(Show, SeveralPicturesNeedAChoice) {
  write_pixel({{"key.R"}, {"key.G"}, {"key.B"}, {"fill.R"}, {"fill.G"}, {"fill.B"}},
              {1, 1, 1, 0, 1, 0});
  expect_failure({"show", path("out.exr"), "-o", path("a.png")}, 3,
                 {"out.exr", "2 layers", "--layer", "fill", "key"});
  show("a.png", {"--layer", "fill"});
  EXPECT_EQ(first_pixel("a.png"), (std::vector<int>{0, 255, 0}));
  write_pixel({{"Y"}}, {1.0f});
  show("a.png");
  EXPECT_EQ(first_pixel("a.png"), (std::vector<int>{255, 255, 255}));
}

TEST_F(Show, UnusableFilesAndOutputsAreRefused) {
  render(render_words());
  const Words words = {"show", path("out.exr")};
  expect_failure(words, 2, {"--output"});
  expect_failure(words + Words{"-o", path("a.tif")}, 2, {"a.tif", ".exr, .png, .jpg"});
  expect_failure(words + Words{"-o", path("out.exr")}, 2, {"-o", "the frame itself"});
  expect_failure(words + Words{"-o", path("a.png"), "--view", "nope"}, 2, {"--view", "ACES"});
  expect_failure(words + Words{"-o", path("a.png"), "--memory-limit", "1K"}, 3, {"out.exr"});
  expect_failure(words + Words{"-o", path("missing/a.png")}, 1, {"missing/a.png"});
  write("bad.exr", "no picture");
  expect_failure({"show", path("bad.exr"), "-o", path("a.png")}, 3, {"bad.exr", "not EXR"});
  std::vector<unsigned char> bytes;
  for (const auto byte : read_bytes(path("out.exr"))) bytes.push_back(byte);
  write("cut.exr", std::string(bytes.begin(), bytes.begin() + long(bytes.size() / 2)));
  expect_failure({"show", path("cut.exr"), "-o", path("a.png")}, 3, {"cut.exr"});
}

TEST_F(Show, InfoListsLayersSettingsAndState) {
  render(render_words({"--aov", "albedo", "--half", "albedo", "--spp", "4", "--seed", "7", "--crop",
                       "3,2,13,11", "--resumable"}));
  const nlohmann::json json = info();
  EXPECT_EQ(json["width"], 16);
  EXPECT_EQ(json["window"], (nlohmann::json{3, 2, 13, 11}));
  EXPECT_EQ(json["layers"][0]["name"], "RGBA");
  EXPECT_EQ(json["layers"][0]["channels"][3]["name"], "A");
  EXPECT_EQ(json["layers"][0]["channels"][3]["type"], "float");
  const auto albedo = std::ranges::find_if(
      json["layers"], [](const nlohmann::json& layer) { return layer["name"] == "albedo"; });
  ASSERT_NE(albedo, json["layers"].end());
  EXPECT_EQ((*albedo)["channels"].size(), 3u);
  EXPECT_EQ((*albedo)["channels"][0]["type"], "half");
  EXPECT_EQ(json["settings"]["seed"], "7");
  EXPECT_TRUE(json["versions"].contains("emberline"));
  EXPECT_EQ(json["state"]["complete"], true);
  EXPECT_EQ(json["state"]["samples"], 4 * 10 * 9);
  EXPECT_EQ(json["state"]["samples_per_pixel"], 4.0);
  EXPECT_EQ(json["state"]["extensible"], true);
  const RunResult text = run({"info", path("out.exr")});
  for (const char* part : {"16 x 16", "3,2 to 13,11", "complete, 360 samples (4 per pixel)",
                           "emberline extend", "albedo.R albedo.G albedo.B (half)", "  seed "}) {
    EXPECT_NE(text.out.find(part), std::string::npos) << part << "\n" << text.out;
  }
  for (const char* default_value : {"  fps ", "  isa ", "  command ", "  explanation "}) {
    EXPECT_EQ(text.out.find(default_value), std::string::npos) << text.out;
  }
}

TEST_F(Show, InfoKeepsWhatIsNoSettingApart) {
  run({"render", scene(), "-o", path("a b.exr"), "--size", "16x16", "--driver", "adaptive", "--spp",
       "16", "--explain", "3,4", "--resumable"});
  const RunResult text = run({"info", path("a b.exr")});
  EXPECT_NE(text.out.find("emberline extend '" + path("a b.exr") + "'"), std::string::npos)
      << text.out;
  const RunResult result = run({"info", path("a b.exr"), "--json"});
  const nlohmann::json json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json["settings"].size(), 3u) << json["settings"];  // size, driver and spp
  EXPECT_EQ(json["settings"]["driver"], "adaptive");
  EXPECT_EQ(json["explanation"].get<std::string>().find("3,4: At "), 0u);
  EXPECT_EQ(json["explanation"].get<std::string>().back(), '.');
  EXPECT_NE(json["command"].get<std::string>().find("emberline render"), std::string::npos);
}

// Options that tell how to read a scene have no meaning for a frame.
TEST_F(Show, InfoOfAFrameTakesNoOptionsOfAScene) {
  render(render_words());
  for (const Words& words : {Words{"--sun", "30,40"}, Words{"--lenient"}, Words{"--edits"}}) {
    expect_failure(Words{"info", path("out.exr")} + words, 2, {words[0], "is a frame"});
  }
}

TEST_F(Show, InfoSaysWhyAFrameCannotBeExtended) {
  render(render_words());
  EXPECT_EQ(info()["state"]["extensible"], false);
  EXPECT_NE(info()["state"]["obstacle"].get<std::string>().find("out.exr.checkpoint"),
            std::string::npos);
  write("out.exr.checkpoint", "junk");
  EXPECT_EQ(info()["state"]["extensible"], false);
  std::filesystem::remove(path("out.exr.checkpoint"));
  // The samples of this sampler depend on their total number, so its frame cannot be extended.
  render(render_words({"--resumable", "--sampler", "stratified"}));
  EXPECT_NE(info()["state"]["obstacle"].get<std::string>().find("sampler"), std::string::npos);
  // A later frame then replaces the picture but not the checkpoint.
  render(render_words({"--resumable", "--sampler", "sobol"}));
  EXPECT_EQ(info()["state"]["extensible"], true);
  render(render_words({"--seed", "5", "--sampler", "sobol"}));
  EXPECT_NE(info()["state"]["obstacle"].get<std::string>().find("another frame: --seed 5"),
            std::string::npos);
  write_pixel({{"R"}, {"G"}, {"B"}, {"depth.Z"}}, {1, 1, 1, 1});
  EXPECT_TRUE(info()["state"]["complete"].is_null());
  EXPECT_EQ(info()["layers"][1]["name"], "depth");
}

class CompareLayer : public Show {
 protected:
  nlohmann::json metrics(const Words& more) {
    const RunResult result =
        run(Words{"compare", path("out.exr"), path("reference.exr"), "--json"} + more);
    EXPECT_EQ(result.exit_code, 0) << result.describe();
    err_ = result.err;
    return nlohmann::json::parse(result.out);
  }
  std::string err_;
};

TEST_F(CompareLayer, MeasuresIt) {
  write_pixel({{"R"}, {"G"}, {"B"}, {"denoised.R"}, {"denoised.G"}, {"denoised.B"}, {"id"}},
              {0.5f, 0.5f, 0.5f, 0.25f, 0.25f, 0.25f, 3.0f});
  std::filesystem::rename(path("out.exr"), path("reference.exr"));
  write_pixel({{"R"}, {"G"}, {"B"}, {"denoised.R"}, {"denoised.G"}, {"denoised.B"}, {"id"}},
              {1.0f, 1.0f, 1.0f, 0.75f, 0.75f, 0.75f, 5.0f});
  EXPECT_NEAR(metrics({})["mse"].get<double>(), 0.25, 1e-6);
  EXPECT_NE(err_.find("--layer denoised"), std::string::npos) << err_;
  EXPECT_EQ(std::ranges::count(err_, '\n'), 1) << err_;
  EXPECT_NEAR(metrics({"--layer", "denoised"})["rmse"].get<double>(), 0.5, 1e-6);
  EXPECT_EQ(err_, "");
  EXPECT_NEAR(metrics({"--layer", "id"})["rmse"].get<double>(), 2.0, 1e-6);
}

TEST_F(CompareLayer, ARawReferenceServesADenoisedLayer) {
  write_pixel({{"R"}, {"G"}, {"B"}, {"id"}}, {0.5f, 0.5f, 0.5f, 1.0f});
  std::filesystem::rename(path("out.exr"), path("reference.exr"));
  write_pixel({{"R"},
               {"G"},
               {"B"},
               {"denoised.R"},
               {"denoised.G"},
               {"denoised.B"},
               {"a.R"},
               {"a.G"},
               {"a.B"}},
              {1, 1, 1, 0.75f, 0.75f, 0.75f, 0, 0, 0});
  EXPECT_NEAR(metrics({"--layer", "denoised"})["rmse"].get<double>(), 0.25, 1e-6);
  EXPECT_NE(err_.find("reference.exr has no layer denoised"), std::string::npos) << err_;
  expect_failure({"compare", path("out.exr"), path("reference.exr"), "--layer", "a"}, 2,
                 {"reference.exr", "unknown layer 'a'", "id"});
}

// If a reference has a single layer, that layer is found under any of its names.
TEST_F(CompareLayer, AReferenceOfOneLayerHasItsChannels) {
  write_pixel({{"R"}, {"G"}, {"B"}}, {0.5f, 0.25f, 0.0f});
  std::filesystem::rename(path("out.exr"), path("reference.exr"));
  write_pixel({{"R"}, {"G"}, {"B"}, {"A"}, {"key.R"}, {"key.G"}, {"key.B"}},
              {1.0f, 1.0f, 1.0f, 1.0f, 0, 0, 0});
  EXPECT_NEAR(metrics({"--layer", "R"})["rmse"].get<double>(), 0.5, 1e-6);
  EXPECT_EQ(err_, "");
  metrics({"--layer", "RGBA"});
  EXPECT_EQ(err_, "");
  EXPECT_NEAR(metrics({"--layer", "key"})["max_abs"].get<double>(), 0.5, 1e-6);
  EXPECT_NE(err_.find("using its picture as the reference"), std::string::npos) << err_;
}

// There must be no hint that suggests the layer that is already measured or shown.
TEST_F(CompareLayer, ADenoisedLayerAloneNeedsNoHint) {
  write_pixel({{"denoised.R"}, {"denoised.G"}, {"denoised.B"}}, {0.5f, 0.5f, 0.5f});
  std::filesystem::copy_file(path("out.exr"), path("reference.exr"));
  EXPECT_EQ(metrics({})["mse"], 0.0);
  EXPECT_EQ(err_, "");
  EXPECT_EQ(show("a.png").err.find("not denoised"), std::string::npos);
}

class ShowSequence : public Show {
 protected:
  void write_depths(const std::string& name, float depth) {
    write_pixel({{"R"}, {"G"}, {"B"}, {"Z"}}, {1, 1, 1, depth});
    std::filesystem::rename(path("out.exr"), path(name));
  }
  RunResult show_all(const Words& more) { return run(Words{"show", path("a.#.exr")} + more); }
  // Returns the durations of the frames of a GIF in hundredths of a second.
  std::vector<int> durations(const std::string& name) {
    const std::vector<uint8_t> gif = read_bytes(path(name));
    std::vector<int> list;
    // A frame begins with a graphic control extension.
    for (size_t i = 0; i + 8 < gif.size(); ++i) {
      const bool begins = gif[i] == 0x21 && gif[i + 1] == 0xf9 && gif[i + 2] == 4;
      if (begins && gif[i + 7] == 0) list.push_back(gif[i + 4] + 256 * gif[i + 5]);
    }
    return list;
  }
};

TEST_F(ShowSequence, ConvertsEachFrameAndAnimatesAll) {
  render({"render", scene(), "-o", path("a.#.exr"), "--frames", "1-3", "--size", "24x16", "--spp",
          "1"});
  const RunResult all = show_all({"-o", path("b.#.png"), "-o", path("b.gif")});
  EXPECT_EQ(all.exit_code, 0) << all.describe();
  EXPECT_EQ(durations("b.gif"), (std::vector<int>{4, 4, 4}));
  for (const std::string frame : {"1", "2", "3"}) {
    run({"show", path("a." + frame + ".exr"), "-o", path("alone.png")});
    EXPECT_EQ(read_bytes(path("b." + frame + ".png")), read_bytes(path("alone.png"))) << frame;
  }
  const RunResult some = show_all({"-o", path("c.gif"), "--frames", "3,1", "--fps", "10"});
  EXPECT_EQ(some.exit_code, 0) << some.describe();
  EXPECT_EQ(durations("c.gif"), (std::vector<int>{10, 10}));
}

// A frame that cannot be shown costs one line and does not end the sequence.
TEST_F(ShowSequence, GoesOnAfterAFrameThatFails) {
  for (const char* name : {"a.1.exr", "a.2.exr", "a.4.exr"}) write_depths(name, 1);
  write("a.2.exr", "no picture");
  write_exr_file(path("a.4.exr"),
                 {.width = 1,
                  .height = 1,
                  .data_window = {0, 0, 1, 1},
                  .channels = {{"R"}, {"G"}, {"B"}},
                  .attributes = {}},
                 std::vector<float>{1, 1, 1});
  const RunResult result = show_all({"-o", path("a.gif"), "--frames", "1-4"});
  EXPECT_EQ(result.exit_code, 3) << result.describe();
  for (const char* text :
       {"a.2.exr", "a.3.exr",
        "a.4.exr: it has 1 x 1 pixels, but the other frames of the animation have 2 x 1",
        "(1 frame)"}) {
    EXPECT_NE(result.err.find(text), std::string::npos) << text << result.err;
  }
  EXPECT_EQ(durations("a.gif").size(), 1u);
}

// If an animation needs too much memory, the pictures are still written.
TEST_F(ShowSequence, AnimationsEndAtTheMemoryLimit) {
  render({"render", scene(), "-o", path("a.#.exr"), "--frames", "1-40", "--size", "64x48", "--spp",
          "1"});
  const RunResult result =
      show_all({"-o", path("b.#.png"), "-o", path("b.gif"), "--memory-limit", "1000K"});
  EXPECT_EQ(result.exit_code, 3) << result.describe();
  const size_t first = result.err.find("emberline: error:");
  EXPECT_NE(first, std::string::npos) << result.err;
  EXPECT_EQ(result.err.find("emberline: error:", first + 1), std::string::npos) << result.err;
  EXPECT_TRUE(std::filesystem::exists(path("b.40.png")));
  const size_t count = durations("b.gif").size();
  EXPECT_GT(count, 1u);
  EXPECT_LT(count, 40u);
}

TEST_F(ShowSequence, FramesShareBlackAndWhite) {
  write_depths("a.1.exr", -2);
  write_depths("a.2.exr", 0);
  write_depths("a.3.exr", 2);
  const RunResult result = show_all({"-o", path("z.#.png"), "--layer", "Z", "--view", "Raw"});
  EXPECT_EQ(result.exit_code, 0) << result.describe();
  EXPECT_EQ(first_pixel("z.1.png")[0], 0);
  EXPECT_EQ(first_pixel("z.2.png")[0], 128);
  EXPECT_EQ(first_pixel("z.3.png")[0], 255);
}

TEST_F(ShowSequence, RejectsNamesOptionsAndSizes) {
  for (const char* name : {"a.1.exr", "a.2.exr"}) write_depths(name, 1);
  const Words sequence = {"show", path("a.#.exr"), "-o"};
  expect_failure(sequence + Words{path("b.png")}, 2, {"-o", "b.####.png"});
  expect_failure(sequence + Words{path("a.#.exr")}, 2, {"it is a frame of the sequence"});
  expect_failure(sequence + Words{path("b.gif"), "--fps", "0"}, 2, {"--fps"});
  expect_failure(sequence + Words{path("b.gif"), "--layer", "none"}, 2, {"none"});
  expect_failure({"show", path("a.1.exr"), "-o", path("b.gif")}, 2, {"b.gif needs a sequence"});
  expect_failure({"show", path("a.1.exr"), "-o", path("b.png"), "--frames", "1"}, 2,
                 {"--frames needs a sequence"});
  expect_failure({"show", path("none.#.exr"), "-o", path("b.gif")}, 3, {"no file"});
  expect_failure({"show", path("a.1.exr"), "-o", path("b.png"), "--fps", "12"}, 2, {"--fps needs"});
}

}  // namespace
}  // namespace emberline::test
