// Tests the output of `emberline render`: files, channels and headers. Pixels must not depend on
// how the work is divided (law 2 in renderer/README.md).
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <thread>

#include "cli/command_test.h"

namespace emberline::test {
namespace {

class Render : public CommandTest {};

TEST_F(Render, SeveralFilesOfOneFrame) {
  const RunResult result =
      render({"render", scene(), "-o", path("a.exr"), "-o", path("a.png"), "-o", path("a.jpg"),
              "-o", path("B.JPEG"), "--size", "20x12", "--spp", "4"});
  EXPECT_EQ(files(), (Words{"B.JPEG", "a.exr", "a.jpg", "a.png", "scene.glb"}));
  for (const char* name : {"a.exr", "a.png", "a.jpg", "B.JPEG"}) {
    EXPECT_NE(result.err.find(std::string("wrote ") + path(name)), std::string::npos) << result.err;
  }
  const ExrPicture exr = read_exr(path("a.exr"));
  const BytePicture png = read_bytes_picture(path("a.png"));
  const BytePicture jpg = read_bytes_picture(path("a.jpg"));
  EXPECT_EQ(png.width, 20);
  EXPECT_EQ(png.height, 12);
  EXPECT_EQ(png.channels, 3);
  EXPECT_EQ(jpg.width, 20);
  EXPECT_EQ(read_bytes(path("a.jpg")), read_bytes(path("B.JPEG")));
  // After the sRGB curve (IEC 61966-2-1), the EXR must match the PNG to within one 8-bit step.
  for (int y = 0; y < 12; ++y) {
    for (int x = 0; x < 20; ++x) {
      const double v = std::min(1.0, double(exr.at("G", x, y)));
      const double srgb = v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1 / 2.4) - 0.055;
      EXPECT_NEAR(png.at(x, y)[1], 255 * srgb, 1.0) << x << ',' << y;
    }
  }
}

TEST_F(Render, HasTheRequestedChannels) {
  const std::map<std::string, std::string> base = {
      {"R", "float"}, {"G", "float"}, {"B", "float"}, {"A", "float"}, {"samples", "uint"}};
  const std::map<std::string, std::map<std::string, std::string>> aovs = {
      {"variance", {{"variance.R", "float"}, {"variance.G", "float"}, {"variance.B", "float"}}},
      {"albedo", {{"albedo.R", "float"}, {"albedo.G", "float"}, {"albedo.B", "float"}}},
      {"N", {{"N.X", "float"}, {"N.Y", "float"}, {"N.Z", "float"}}},
      {"Z", {{"Z", "float"}}},
      {"velocity", {{"velocity.X", "float"}, {"velocity.Y", "float"}}},
      {"id", {{"id", "uint"}}},
      {"time", {{"time", "float"}}}};
  render(render_words({"--spp", "2"}));
  EXPECT_EQ(read_exr(path("out.exr")).types, base);
  auto all = base;
  std::string list;
  for (const auto& [name, channels] : aovs) {
    render(render_words({"--spp", "2", "--aov", name}));
    auto expected = base;
    expected.insert(channels.begin(), channels.end());
    EXPECT_EQ(read_exr(path("out.exr")).types, expected) << name;
    all.insert(channels.begin(), channels.end());
    list += (list.empty() ? "" : ",") + name;
  }
  render(render_words({"--spp", "2", "--aov", list}));
  EXPECT_EQ(read_exr(path("out.exr")).types, all);
  render(render_words({"--aov", "Z", "--aov", "id"}));
  EXPECT_TRUE(read_exr(path("out.exr")).types.contains("Z"));
  EXPECT_TRUE(read_exr(path("out.exr")).types.contains("id"));
}

TEST_F(Render, HeaderRecordsTheSettings) {
  render(render_words({"--seed", "7", "--sampler", "independent", "--filter", "box", "--max-depth",
                       "3", "--spp", "5", "--report", path("it's a report.json")}));
  const auto attributes = read_exr(path("out.exr")).attributes;
  const std::map<std::string, std::string> expected = {
      {"emberline:seed", "7"},     {"emberline:sampler", "independent"},
      {"emberline:filter", "box"}, {"emberline:max_depth", "3"},
      {"emberline:spp", "5"},      {"emberline:integrator", "path"},
      {"emberline:scene", scene()}};
  for (const auto& [name, value] : expected) {
    ASSERT_TRUE(attributes.contains(name)) << name;
    EXPECT_EQ(attributes.at(name), value) << name;
  }
  for (const char* library :
       {"emberline", "embree", "openexr", "openimageio", "libpng", "libjpeg", "opencolorio"}) {
    EXPECT_TRUE(attributes.contains(std::string("emberline:version:") + library)) << library;
  }
  const std::string& sets = attributes.at("emberline:instruction_sets");
  EXPECT_NE(sets.find(", Embree "), std::string::npos) << sets;
  EXPECT_EQ(sets.find("unknown"), std::string::npos) << sets;
  // The command in the header must be usable in a shell.
  const std::string& command = attributes.at("emberline:command");
  EXPECT_TRUE(command.starts_with("emberline render ")) << command;
  EXPECT_NE(command.find("it'\\''s a report.json'"), std::string::npos) << command;
}

TEST_F(Render, CropHasTheSameBitsAsTheWholeFrame) {
  const Words aovs = {"--size", "40x30", "--spp", "3", "--aov", "variance,albedo,N,Z,id"};
  render(render_words(aovs));
  const ExrPicture whole = read_exr(path("out.exr"));
  EXPECT_EQ(whole.data, (Rect{0, 0, 40, 30}));
  for (const Rect& crop : {Rect{7, 5, 33, 21}, Rect{0, 0, 1, 1}, Rect{39, 29, 40, 30}}) {
    const std::string text = std::to_string(crop.x0) + "," + std::to_string(crop.y0) + "," +
                             std::to_string(crop.x1) + "," + std::to_string(crop.y1);
    render(
        render_words(aovs + Words{"--crop", text, "-o", path("crop.png"), "--bucket-size", "8"}));
    const ExrPicture part = read_exr(path("out.exr"));
    EXPECT_EQ(part.data, crop);
    EXPECT_EQ(part.display, (Rect{0, 0, 40, 30}));
    EXPECT_EQ(first_difference(whole, part), "") << text;
    EXPECT_EQ(read_bytes_picture(path("crop.png")).width, crop.width());
  }
}

TEST_F(Render, ThreadsAndBucketsDoNotChangeThePicture) {
  const Words frame = {"--size", "50x34", "--spp", "5", "--aov", "variance,albedo,N,Z,id"};
  render(render_words(frame));
  const ExrPicture reference = read_exr(path("out.exr"));
  for (const Words& schedule :
       {Words{"--threads", "1"}, Words{"--threads", "2", "--bucket-size", "1"},
        Words{"--threads", "7", "--bucket-size", "5"}, Words{"--bucket-order", "spiral"},
        Words{"--bucket-order", "scanline", "--bucket-size", "4096"},
        Words{"--bucket-order", "random", "--bucket-size", "13"},
        Words{"--bucket-order", "hilbert", "--bucket-size", "16", "--threads", "3"}}) {
    render(render_words(frame + schedule));
    const ExrPicture picture = read_exr(path("out.exr"));
    EXPECT_EQ(picture.data, reference.data);
    EXPECT_EQ(first_difference(reference, picture), "") << schedule[0] << ' ' << schedule[1];
  }
  // Check that this comparison can fail.
  render(render_words(frame + Words{"--seed", "1"}));
  EXPECT_NE(first_difference(reference, read_exr(path("out.exr"))), "");
}

// A film of the whole frame must be written in tiles of at least 16 pixels and not pixel by pixel.
// This must hold if it is written directly, through the denoiser's scratch file, or from
// checkpoints.
TEST_F(Render, ProgressiveFramesAreStoredInTilesOfAtLeastSixteenPixels) {
  for (const std::string driver : {"bisection", "adaptive"}) {
    const bool all = driver == "bisection";  // the same code writes the film of the other driver
    const Words frame = {"--size", "50x34", "--spp", "4", "--driver", driver, "--resumable"};
    const auto picture = [&](const char* bucket_size, const Words& more) {
      const Words words = frame + more + Words{"--bucket-size", bucket_size};
      std::filesystem::remove(path("out.exr.checkpoint"));
      render(render_words(words));
      return read_exr(path("out.exr"));
    };
    for (const Words& more : {Words{}, Words{"--aov", "denoising"}, Words{"--denoise"},
                              Words{"--light-groups", "--crop", "7,5,49,34"}}) {
      SCOPED_TRACE(driver + (more.empty() ? "" : more.front()));
      const ExrPicture whole = picture("64", more);
      EXPECT_EQ(whole.tile_size, 64);
      for (const auto& [bucket_size, tile_size] :
           {std::pair("5", 20), std::pair("1", 16), std::pair("15", 30), std::pair("17", 17)}) {
        const ExrPicture seen = picture(bucket_size, more);
        EXPECT_EQ(seen.tile_size, tile_size) << bucket_size;
        EXPECT_EQ(first_difference(whole, seen), "") << bucket_size;
        if (!all) break;
      }
    }
    std::vector<ExrPicture> merged, extended;
    for (const char* bucket_size : {"64", "1"}) {
      picture(bucket_size, {});
      render({"extend", path("out.exr"), "--spp", "8"});
      extended.push_back(read_exr(path("out.exr")));
      for (const char* seed : {"1", "2"}) {
        picture(bucket_size, {"--seed", seed});
        std::filesystem::rename(path("out.exr.checkpoint"), path(seed));
      }
      render({"merge", path("1"), path("2"), "-o", path("merged.exr")});
      merged.push_back(read_exr(path("merged.exr")));
    }
    EXPECT_EQ(extended[1].tile_size, 16);
    EXPECT_EQ(first_difference(extended[0], extended[1]), "");
    EXPECT_EQ(merged[1].tile_size, 16);
    EXPECT_EQ(first_difference(merged[0], merged[1]), "");
  }
  // The bucket driver writes each bucket as a tile.
  render(render_words({"--bucket-size", "5"}));
  EXPECT_EQ(read_exr(path("out.exr")).tile_size, 5);
}

// Parses the exact values that follow "radiance" as "(0x1.8p-3 0x... 0x...)".
std::vector<float> replayed_radiance(const std::string& text) {
  const size_t at = text.find('(', text.find("\nradiance "));
  std::vector<float> values;
  const char* p = text.c_str() + at + 1;
  for (int i = 0; i < 3; ++i) {
    char* end = nullptr;
    values.push_back(std::strtof(p, &end));
    EXPECT_NE(p, end) << text;
    p = end;
  }
  return values;
}

TEST_F(Render, ReplayReproducesThePixelsBits) {
  const Words frame = {"--size", "24x24", "--seed", "3"};
  render(render_words(frame));
  const ExrPicture picture = read_exr(path("out.exr"));
  int lit = 0;
  for (const auto& [x, y] : {std::pair{0, 0}, {12, 15}, {11, 13}, {23, 23}, {12, 8}}) {
    const std::string address = std::to_string(x) + "," + std::to_string(y) + ",0";
    const RunResult result = run(
        {"render", scene(), "--size", "24x24", "--seed", "3", "--spp", "1", "--replay", address});
    ASSERT_EQ(result.exit_code, 0) << result.describe();
    EXPECT_NE(result.out.find("pixel " + std::to_string(x)), std::string::npos) << result.out;
    const std::vector<float> value = replayed_radiance(result.out);
    for (size_t c = 0; c < 3; ++c) {
      EXPECT_EQ(value[c], picture.at(std::string(1, "RGB"[c]), x, y)) << address << result.out;
    }
    lit += value[0] > 0;
    EXPECT_EQ(run({"render", scene(), "--size", "24x24", "--seed", "3", "--replay", address}).out,
              result.out);
  }
  EXPECT_GT(lit, 0) << "every pixel looked at was black";
}

TEST_F(Render, ReplayWritesNoFile) {
  const Words before = (scene(), files());
  const RunResult result = run(render_words({"--replay", "1,1,0", "--report", path("r.json")}));
  EXPECT_EQ(result.exit_code, 0) << result.describe();
  EXPECT_EQ(files(), before);
}

TEST_F(Render, PathsMayContainAnyCharacter) {
  const std::string folder = path("dir with ümlaut ß 日本 'quote' 100%");
  std::filesystem::create_directories(folder + "/below");
  const std::string file = lamp_scene().write_gltf(folder + "/a scene #1.gltf", "bin ä.bin");
  const RunResult absolute =
      render({"render", file, "-o", folder + "/ö.exr", "-o", folder + "/ö.png", "--size", "4x4",
              "--spp", "1", "--report", folder + "/r ß.json"});
  EXPECT_TRUE(std::filesystem::exists(folder + "/ö.exr")) << absolute.describe();
  EXPECT_TRUE(std::filesystem::exists(folder + "/ö.png"));
  EXPECT_TRUE(std::filesystem::exists(folder + "/r ß.json"));
  RunOptions below;
  below.folder = folder + "/below";
  render({"render", "../a scene #1.gltf", "-o", "./x.exr", "-o", "../y.png", "--size", "4x4",
          "--spp", "1", "--report", "r.json"},
         below);
  EXPECT_TRUE(std::filesystem::exists(folder + "/below/x.exr"));
  EXPECT_TRUE(std::filesystem::exists(folder + "/y.png"));
  EXPECT_EQ(first_difference(read_exr(folder + "/ö.exr"), read_exr(folder + "/below/x.exr")), "");
}

TEST_F(Render, ExistingFilesAreReplacedAtomically) {
  write("out.exr", std::string(100000, 'x'));
  std::filesystem::create_symlink("out.exr", path("link.exr"));
  render({"render", scene(), "-o", path("link.exr"), "--size", "4x4", "--spp", "1"});
  EXPECT_TRUE(std::filesystem::is_symlink(path("link.exr")));
  EXPECT_EQ(read_exr(path("out.exr")).data, (Rect{0, 0, 4, 4}));
}

TEST_F(Render, TwoRendersToOneFileLeaveOneCompleteFrame) {
  Process first(render_words({"--size", "200x200"}), {.folder = folder_.path()});
  Process second(render_words({"--size", "200x200"}), {.folder = folder_.path()});
  EXPECT_EQ(first.wait().exit_code, 0);
  EXPECT_EQ(second.wait().exit_code, 0);
  EXPECT_EQ(read_exr(path("out.exr")).data, (Rect{0, 0, 200, 200}));
  EXPECT_EQ(files(), (Words{"out.exr", "scene.glb"}));
}

TEST_F(Render, AnInvalidOcioConfigIsNamed) {
  write("rubbish.ocio", "this is no config\n");
  for (const char* config : {"/nonexistent/config.ocio", "rubbish.ocio", "/"}) {
    expect_failure(render_words({"-o", path("a.png")}), 3, {config, "OCIO"},
                   {.environment = {{"OCIO", config}}});
  }
  // OCIO is not needed if only linear pixels are written. An empty value counts as unset.
  render(render_words(), {.environment = {{"OCIO", "rubbish.ocio"}}});
  render(render_words({"-o", path("a.png")}), {.environment = {{"OCIO", ""}}});
}

// By default there is one thread for each processor that the process may use. With `taskset -c 0`,
// for example, there is one thread.
TEST_F(Render, UsesOneThreadForEachAllowedProcessor) {
  const Words report = {"--report", path("r.json")};
  render(render_words(report), {.processors = 1});
  EXPECT_EQ(read_json("r.json")["settings"]["threads"], 1);
  render(render_words(report), {.environment = {{"SLURM_CPUS_PER_TASK", "4000"}}, .processors = 1});
  EXPECT_EQ(read_json("r.json")["settings"]["threads"], 1);
  render(render_words(report + Words{"--threads", "2"}), {.processors = 1});
  EXPECT_EQ(read_json("r.json")["settings"]["threads"], 2);
}

// TBB would abort the process if it could not start a thread.
TEST_F(Render, UsesAsManyThreadsAsTheSystemStarts) {
  if (::getuid() != 0) GTEST_SKIP() << "limits count all that a user runs; root can become another";
  scene();
  std::filesystem::permissions(folder_.path(), std::filesystem::perms::all);
  // The limit allows for libraries, which also start one thread per core.
  const uint64_t limit = 40 + 4 * std::max(1u, std::thread::hardware_concurrency());
  for (const char* command : {"render", "study"}) {
    SCOPED_TRACE(command);
    expect_failure({command, scene(), "-o", path("out.exr"), "--threads", "4096"}, 1,
                   {"--threads 4096", "the system allows at most", "lower --threads"},
                   {.process_limit = limit});
  }
  // Each run is that of another user, who may not overwrite the files of the other runs.
  const auto words = [this](const std::string& output) {
    return Words{"render", scene(), "-o", path(output), "--size", "16x16", "--spp", "1"};
  };
  render(words("a.exr") + Words{"--threads", "4"}, {.process_limit = limit});
  // With the limit `tight`, only one worker can start, so the default number of threads is reduced
  // to 1.
  const std::string err =
      run(words("b.exr") + Words{"--threads", "4096"}, {.process_limit = limit}).err;
  const std::string before = "at most ";
  const uint64_t most = std::stoull(err.substr(err.find(before) + before.size()));
  const uint64_t tight = limit - most + 1;
  render(words("b.exr") + Words{"--report", path("r.json")}, {.process_limit = tight});
  EXPECT_EQ(read_json("r.json")["settings"]["threads"], 1);
  const RunResult info = run({"info", scene()}, {.process_limit = tight});
  EXPECT_EQ(info.exit_code, 0) << info.describe();
  expect_failure(words("c.exr"), 1, {"ulimit -u"}, {.process_limit = tight - 1});
}

}  // namespace
}  // namespace emberline::test
