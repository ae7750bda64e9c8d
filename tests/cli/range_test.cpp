// Tests --frames and --turntable. Each frame of a range must equal the same frame rendered alone.
#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numeric>

#include "cli/command_test.h"
#include "support/animated_gltf.h"

namespace emberline::test {
namespace {

namespace fs = std::filesystem;

class Range : public CommandTest {
 protected:
  Words range_words(const Words& more = {}) {
    return Words{"render", scene(), "-o", path("a.##.exr"), "--size", "24x16", "--spp", "4"} + more;
  }
  Words turn(const Words& more = {}) { return range_words(Words{"--turntable", "4"} + more); }
  // Returns a range whose frames take hours.
  Words endless(const Words& more = {}) {
    return Words{"render",
                 scene(),
                 "-o",
                 path("a.#.exr"),
                 "--size",
                 "1024x1024",
                 "--spp",
                 "4096",
                 "--bucket-size",
                 "16",
                 "--turntable",
                 "4",
                 "--range-report",
                 path("range.json"),
                 "--verbose"} +
           more;
  }
  nlohmann::json range() const { return read_json("range.json"); }
};

TEST_F(Range, TurntableFramesEqualSingleFrames) {
  for (const char* driver : {"bucket", "bisection", "adaptive"}) {
    SCOPED_TRACE(driver);
    render(turn({"--driver", driver, "--aov", "N,Z"}));
    for (int frame = 1; frame <= 4; ++frame) {
      const std::string number = std::to_string(frame);
      render(range_words({"-o", path("alone.exr"), "--driver", driver, "--aov", "N,Z",
                          "--turntable", number + "/4"}));
      EXPECT_EQ(
          first_difference(read_exr(path("a.0" + number + ".exr")), read_exr(path("alone.exr"))),
          "")
          << frame;
    }
  }
}

TEST_F(Range, TurntableBeginsWithTheOriginalCamera) {
  render(turn({"--static-noise"}));
  const ExrPicture first = read_exr(path("a.01.exr"));
  render(render_words({"--size", "24x16", "--spp", "4"}));
  EXPECT_EQ(first_difference(first, read_exr(path("out.exr"))), "");
  EXPECT_NE(first_difference(first, read_exr(path("a.02.exr"))), "");
  // A turntable continues beyond its last frame.
  render(turn({"--frames", "-3,5,9", "--static-noise"}));
  for (const char* again : {"a.-3.exr", "a.05.exr", "a.09.exr"}) {
    EXPECT_EQ(first_difference(first, read_exr(path(again))), "") << again;
  }
}

// Returns the correlation of two pictures' noise. Values beyond the 90th percentile are limited,
// because otherwise a few bright pixels would decide.
double noise_correlation(const ExrPicture& a, const ExrPicture& b, const ExrPicture& truth) {
  const auto noise_of = [&](const ExrPicture& picture) {
    std::vector<double> noise(picture.channels.at("R").size());
    for (const char* c : {"R", "G", "B"}) {
      const std::vector<float>&shown = picture.channels.at(c), &right = truth.channels.at(c);
      for (size_t i = 0; i < noise.size(); ++i) {
        noise[i] += double(shown[i] - right[i]) / (double(right[i]) + 0.1);
      }
    }
    std::vector<double> sizes = noise;
    for (double& size : sizes) size = std::abs(size);
    std::ranges::sort(sizes);
    const double limit = sizes[sizes.size() * 9 / 10];
    for (double& value : noise) value = std::clamp(value, -limit, limit);
    return noise;
  };
  const std::vector<double> x = noise_of(a), y = noise_of(b);
  const auto product = [](const std::vector<double>& u, const std::vector<double>& v) {
    return std::inner_product(u.begin(), u.end(), v.begin(), 0.0);
  };
  EXPECT_GT(product(x, x), 0);
  return product(x, y) / std::sqrt(product(x, x) * product(y, y));
}

// The camera hardly moves, so that only noise differs. In two other scenes of this size, 28 pairs
// of frames, or of seeds, had correlations of .02 with a standard deviation of .02 at most, as the
// truth has noise, too. The seed is fixed.
TEST_F(Range, EachFrameHasNoiseOfItsOwn) {
  const auto frame = [&](const Words& words) {
    render(render_words(
        Words{"--size", "96x72", "--spp", "4", "--look-from", "0,1,3", "--look-at", "0,0.5,0"} +
        words));
    return read_exr(path("out.exr"));
  };
  const ExrPicture truth = frame({"--spp", "1024", "--seed", "9"});
  const Words one = {"--turntable", "1/1000000"}, two = {"--turntable", "2/1000000"};
  const Words still = {"--static-noise"};
  EXPECT_LT(std::abs(noise_correlation(frame(one), frame(two), truth)), 0.12);
  EXPECT_LT(std::abs(noise_correlation(frame(one), frame({}), truth)), 0.12);
  EXPECT_GT(noise_correlation(frame(one + still), frame(two + still), truth), 0.9);
}

TEST_F(Range, ReplaysASampleOfAFrame) {
  const Words replay = {"--replay", "11,7,2"};
  const RunResult alone = run(range_words(Words{"--turntable", "2/4"} + replay));
  ASSERT_EQ(alone.exit_code, 0) << alone.describe();
  EXPECT_TRUE(alone.out.starts_with("pixel 11,7 sample 2 seed 0 turntable 2/4\n")) << alone.out;
  EXPECT_EQ(run(turn(Words{"--frames", "2"} + replay)).out, alone.out);
  EXPECT_NE(run(turn(Words{"--frames", "3"} + replay)).out, alone.out);
}

// Tests the other inputs and outputs of a frame, such as edits and checkpoints.
TEST_F(Range, EveryFrameWritesAllItsFiles) {
  render(turn({"-o",
               path("a.#.png"),
               "--heatmap",
               path("h.#.png"),
               "--report",
               path("r.#.json"),
               "--report",
               path("r.#.html"),
               "--light-groups",
               "--resumable",
               "--save-settings",
               path("look.json"),
               "--range-report",
               path("range.json"),
               "--driver",
               "bisection",
               "--snapshots",
               path("shots.#"),
               "--frames",
               "2,4"}));
  for (const std::string frame : {"2", "4"}) {
    for (const char* name : {"a.0#.exr", "a.#.png", "h.#.png", "r.#.json", "r.#.html",
                             "a.0#.exr.checkpoint", "shots.#/refinement.gif"}) {
      std::string file = name;
      file.replace(file.find('#'), 1, frame);
      EXPECT_TRUE(fs::exists(path(file))) << file;
    }
    const nlohmann::json report = read_json("r." + frame + ".json");
    EXPECT_EQ(report["settings"]["turntable"], frame + "/4");
    EXPECT_EQ(report["output"][1], path("a." + frame + ".png"));
    EXPECT_TRUE(report["complete"]);
  }
  EXPECT_EQ(read_json("look.json")["turntable"], "4");
  EXPECT_EQ(range()["done"], "2,4");
  EXPECT_EQ(range()["exit_code"], 0);
  EXPECT_EQ(range()["frames"].size(), 2u);
}

TEST_F(Range, AnAnimationPosesEachFrame) {
  GltfBuilder gltf = lamp_scene();
  constexpr int kLamp = 2;  // the index of the lamp's node
  AnimationBuilder(gltf).move(kLamp, "translation", {0, 1}, "VEC3", {0, 0, 0, 0.5f, 0, 0.5f});
  const Words words = {
      "render",  gltf.write_glb(path("moving.glb")), "--size", "24x16", "--spp", "4", "--fps", "12",
      "--report"};
  render(words + Words{path("r.#.json"), "-o", path("a.#.exr"), "--frames", "0-18x3"});
  for (const std::string frame : {"0", "6", "9", "12", "18"}) {
    render(words + Words{path("r.json"), "-o", path("b.exr"), "--frame", frame});
    EXPECT_EQ(first_difference(read_exr(path("a." + frame + ".exr")), read_exr(path("b.exr"))), "")
        << frame;
  }
  EXPECT_NE(first_difference(read_exr(path("a.0.exr")), read_exr(path("a.9.exr"))), "");
  // The memory of a pose must be released when the next pose is built.
  const auto reserved = [&](const std::string& name) {
    return read_json(name)["memory"]["most_reserved_bytes"].get<double>();
  };
  EXPECT_LT(reserved("r.18.json"), 1.02 * reserved("r.3.json"));
  // With a turntable, the scene is at rest unless an animation is requested.
  const Words turned = words + Words{path("r.#.json"), "-o",   path("t.#.exr"), "--turntable", "12",
                                     "--frames",       "1,13", "--static-noise"};
  const auto same = [&] {
    return first_difference(read_exr(path("t.1.exr")), read_exr(path("t.13.exr"))).empty();
  };
  render(turned);
  EXPECT_TRUE(same());
  render(turned + Words{"--animation", "0"});
  EXPECT_FALSE(same());
}

// The scene has 500,000 triangles, which must be loaded and built only once.
TEST_F(Range, StaticPartsAreLoadedAndBuiltOnce) {
  GltfBuilder gltf = lamp_scene();
  constexpr int kSide = 500;
  std::vector<float> positions;
  std::vector<uint32_t> indices;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      positions.insert(positions.end(), {float(x) / kSide, 0.1f, float(y) / kSide});
      if (x + 1 == kSide || y + 1 == kSide) continue;
      const auto at = uint32_t(y * kSide + x), below = at + kSide;
      for (const uint32_t i : {at, below, at + 1, at + 1, below, below + 1}) indices.push_back(i);
    }
  }
  const int points = gltf.add_accessor<float>("VEC3", positions);
  gltf.add_mesh_node(gltf.add_mesh({{"attributes", {{"POSITION", points}}},
                                    {"indices", gltf.add_accessor<uint32_t>("SCALAR", indices)}}));
  render({"render", gltf.write_glb(path("grid.glb")), "-o", path("g.#.exr"), "--size", "8x8",
          "--spp", "1", "--turntable", "7", "--report", path("r.#.json"), "--resume"});
  const auto seconds = [&](const std::string& name) {
    const nlohmann::json time = read_json(name)["time"];
    return time["load_s"].get<double>() + time["build_s"].get<double>();
  };
  // The times of a frame must add up to its whole time. Other load may delay most of the later
  // frames, but hardly all six of them.
  std::vector<double> loads, gaps;
  for (int frame = 1; frame <= 7; ++frame) {
    const std::string name = "r." + std::to_string(frame) + ".json";
    const nlohmann::json t = read_json(name)["time"];
    double sum = 0;
    for (const char* part : {"setup_s", "load_s", "build_s", "render_s", "write_s", "snapshots_s"})
      sum += t[part].get<double>();
    const double wall = t["wall_s"].get<double>();
    EXPECT_LE(sum, wall + 0.02) << name;
    if (frame == 1) continue;
    gaps.push_back(wall - sum - 0.1 * wall);
    loads.push_back(seconds(name));
  }
  EXPECT_LT(std::ranges::min(loads), 0.05 * seconds("r.1.json"));
  EXPECT_LT(std::ranges::min(gaps), 0.02);
  EXPECT_TRUE(read_json("r.2.json")["time"]["start_s"].is_null());
}

TEST_F(Range, FailedFrameDoesNotEndTheRange) {
  fs::create_directory(path("a.02.exr"));  // makes it impossible to write this frame
  const Words words = turn({"--range-report", path("range.json")});
  const RunResult result = run(words);
  EXPECT_EQ(result.exit_code, 1) << result.describe();
  EXPECT_NE(result.err.find("emberline: error: frame 2: "), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("1 failed (2)"), std::string::npos) << result.err;
  for (const char* name : {"a.01.exr", "a.03.exr", "a.04.exr"}) EXPECT_TRUE(fs::exists(path(name)));
  EXPECT_EQ(range()["done"], "1,3-4");
  EXPECT_EQ(range()["failed"], "2");
  EXPECT_EQ(range()["exit_code"], 1);
  EXPECT_NE(range()["frames"][1]["error"].get<std::string>().find("a.02.exr"), std::string::npos);

  const RunResult stopped = run(words + Words{"--stop-on-error"});
  EXPECT_EQ(stopped.exit_code, 1);
  EXPECT_EQ(range()["done"], "1");
  EXPECT_EQ(range()["left"], "3-4");
}

TEST_F(Range, CommonErrorsAreReportedOnce) {
  const Words turning = {"--turntable", "100"};
  expect_failure(range_words(turning + Words{"--view", "filmic", "-o", path("a.#.png")}), 2,
                 {"--view"});
  expect_failure(range_words(turning + Words{"--camera", "nope"}), 2, {"no camera"});
  write("broken.gltf", "{}");
  expect_failure({"render", path("broken.gltf"), "-o", path("a.#.exr"), "--frames", "1-100"}, 3,
                 {"broken.gltf"});
  expect_failure(range_words({"--frames", "1-3", "--range-report", path("scene.glb")}), 2,
                 {"--range-report", "it is the scene"});
  expect_failure(range_words({"--frames", "1-3", "--replay", "0,0,0"}), 2, {"--replay"});
  expect_failure(render_words({"--stop-on-error"}), 2, {"--frames"});
  expect_failure(render_words({"--skip-existing", "--part", "1/2"}), 2, {"--skip-existing"});
}

TEST_F(Range, MissingFolderIsReportedOnce) {
  const auto lines = [&](const Words& more) {
    const RunResult result = run(range_words(Words{"--frames", "1-3", "-q"} + more));
    EXPECT_EQ(result.exit_code, 1) << result.err;
    EXPECT_NE(result.err.find("nodir does not exist"), std::string::npos) << result.err;
    return std::ranges::count(result.err, '\n');
  };
  for (const char* option : {"--report", "--checkpoint", "--heatmap", "-o"}) {
    const std::string suffix = option == std::string("--report") ? ".json" : ".exr";
    EXPECT_EQ(lines({option, path("nodir/b.##") + suffix}), 1) << option;
  }
  EXPECT_EQ(lines({"--save-settings", path("nodir/s.json")}), 1);
  EXPECT_EQ(lines({"--driver", "adaptive", "--snapshots", path("nodir/##")}), 1);
  EXPECT_EQ(lines({"--driver", "adaptive", "--tree", path("nodir/##.json")}), 1);
  EXPECT_FALSE(fs::exists(path("a.01.exr")));
  // If the folder of one frame cannot be written to, only that frame fails.
  fs::create_directory(path("f1"));
  const RunResult result = run(range_words({"--frames", "1-2", "-o", path("f#/c.exr")}));
  EXPECT_NE(result.err.find("frame 2: cannot write"), std::string::npos) << result.err;
  EXPECT_TRUE(fs::exists(path("f1/c.exr")));
}

// The checks must cover the files that every frame writes, and every existing file.
TEST_F(Range, NamesOfAllFramesAreCheckedBeforeAnythingIsWritten) {
  GltfBuilder textured = lamp_scene();
  textured.push("images", {{"uri", "a.3.png"}});
  textured.push("textures", {{"source", 0}});
  textured.root["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
  render(render_words({"-o", path("a.3.png"), "-o", path("light.exr")}));
  textured.write_gltf(path("t.gltf"), "t.bin");
  const Words frame = {"render", path("t.gltf"), "--size", "8x8",    "--spp",
                       "1",      "--frames",     "1-3",    "--quiet"};
  const Words outputs = {"-o", path("a.#.exr")};
  write("edits.json", "{}");
  fs::create_directory(path("other"));
  fs::create_symlink("a.2.exr", path("link.json"));
  fs::create_symlink("other", path("same"));
  for (const char* name : {"a.2.exr", "r.2.json", "a.2.exr.checkpoint", "notes.2"}) {
    write(name, "what was there");
  }
  const auto refused = [&](const Words& more, const Words& parts) {
    expect_failure(frame + more, 2, parts);
  };
  for (const char* option : {"--save-settings", "--progress-file", "--range-report"}) {
    refused(outputs + Words{option, path("a.2.exr")},
            {"-o", "a.2.exr", option, "it is also written by"});
    refused(outputs + Words{option, path("link.json")}, {"-o", "a.2.exr", option});
    refused(outputs + Words{option, path("r.2.json"), "--report", path("r.#.json")},
            {"--report", "r.2.json", option, "it is also written by"});
    refused(outputs + Words{option, path("a.2.exr.checkpoint"), "--resume"},
            {"--checkpoint", option, "it is also written by"});
    refused(outputs + Words{option, path("s.2/refinement.gif"), "--driver", "bisection",
                            "--snapshots", path("s.#")},
            {"s.2", option, "it is also written by"});
    refused(outputs + Words{option, path("a.3.png")}, {option, "the scene reads"});
    refused(outputs + Words{option, path("t.bin")}, {option, "the scene reads"});
    refused(outputs + Words{option, path("edits.json"), "--edits", path("edits.json")},
            {option, "--edits"});
  }
  refused({"-o", path("a.#.png")}, {"-o", "a.3.png", "the scene reads"});
  refused(outputs + Words{"--env", path("a.2.exr")}, {"-o", "--env"});
  refused(outputs + Words{"--reference", path("a.2.exr"), "--driver", "bisection", "--snapshots",
                          path("s.#")},
          {"-o", "--reference"});
  refused(outputs + Words{"--reference", path("a.0#.exr"), "-o", path("a.03.exr.#.exr"), "-o",
                          path("a.0#.exr"), "--driver", "bisection", "--snapshots", path("s.#")},
          {"--reference"});
  refused({"-o", path("other/a.#.exr"), "--heatmap", path("same/a.#.exr")},
          {"it is also written by"});
  refused(outputs + Words{"--checkpoint", path("notes.#")},
          {"notes.2", "not an Emberline checkpoint"});
  // The same checks must apply to a frame that is not part of a range.
  expect_failure(
      {"render", path("t.gltf"), "-o", path("out.exr"), "--progress-file", path("a.3.png")}, 2,
      {"--progress-file", "the scene reads"});
  for (const char* name : {"a.2.exr", "r.2.json", "a.2.exr.checkpoint", "notes.2"}) {
    EXPECT_EQ(fs::file_size(path(name)), 14u) << name;
  }
  // Existing files that the scene does not read are replaced. For the progress file, this happens
  // only after the scene is read.
  write("p.json", "an older file");
  render(frame + outputs +
         Words{"--progress-file", path("p.json"), "--range-report", path("a.4.exr")});
  EXPECT_EQ(read_json("p.json")["state"], "done");
}

// A quarter of a turn must move the camera from the +Z side of the point to its +X side.
TEST_F(Range, ATurntableTurnsAroundThePointThatTheCameraLooksAt) {
  const Words view = {"--look-at", "0.5,0.25,-0.5", "--aov", "P"};
  const auto position = [&](const Words& words) {
    render(render_words(view + words));
    return read_exr(path("out.exr"));
  };
  const Words from = {"--look-from", "1,1,3.5"};
  const Words quarter = {"--turntable", "2/4", "--static-noise"};
  const ExrPicture turned = position(from + quarter + Words{"--turntable-center", "look-at"});
  EXPECT_EQ(first_difference(turned, position({"--look-from", "4.5,1,-1"})), "");
  const ExrPicture bounds = position(from + quarter);
  EXPECT_NE(first_difference(turned, bounds), "");
  EXPECT_EQ(
      first_difference(bounds, position(from + quarter + Words{"--turntable-center", "bounds"})),
      "");
  expect_failure(render_words({"--turntable-center", "look-at"}), 2,
                 {"--turntable-center requires --turntable"});
  expect_failure(render_words(quarter + Words{"--turntable-center", "look-at"}), 2,
                 {"--turntable-center look-at requires --look-at"});
}

TEST_F(Range, SkippingNamesAFrameOfOtherSettings) {
  const Words words = {"render", scene(), "-o", path("a.exr"), "--size", "16x16"};
  const Words skip = {"--skip-existing", "--exposure", "1"};
  render(words + Words{"--spp", "2", "--sun", "30,40"});
  EXPECT_NE(render(words + skip + Words{"--spp", "4"})
                .err.find("skipped: all its outputs exist, but " + path("a.exr") +
                          " has other settings: --spp 2 (now 4), --sun 30,40 (now not given)"),
            std::string::npos);
  EXPECT_NE(
      render(words + skip + Words{"--spp", "2", "--sun", "30,40"}).err.find("outputs exist\n"),
      std::string::npos);
  // A setting that changes no pixel does not count as different, and neither does another order of
  // channels.
  EXPECT_NE(render(words + skip +
                   Words{"--spp", "2", "--sun", "30,40", "--time-limit", "60", "--bucket-order",
                         "spiral"})
                .err.find("outputs exist\n"),
            std::string::npos);
  const Words channels = words + Words{"--spp", "2", "--aov", "N,albedo"};
  render(channels + Words{"--resumable"});
  fs::rename(path("a.exr.checkpoint"), path("whole"));
  render({"merge", path("whole"), "-o", path("a.exr")});
  EXPECT_NE(render(channels + Words{"--skip-existing"}).err.find("outputs exist\n"),
            std::string::npos);
}

TEST_F(Range, ExistingFramesAreSkipped) {
  const Words words =
      turn({"--report", path("r.#.json"), "--skip-existing", "--range-report", path("range.json")});
  render(words + Words{"--frames", "1,3"});
  const auto before = fs::last_write_time(path("a.01.exr"));
  fs::remove(path("r.3.json"));  // one of the outputs of frame 3
  const RunResult result = render(words);
  EXPECT_NE(result.err.find("frame 1 (1 of 4) is skipped"), std::string::npos) << result.err;
  EXPECT_EQ(range()["skipped"], "1");
  EXPECT_EQ(range()["done"], "2-4");
  EXPECT_EQ(fs::last_write_time(path("a.01.exr")), before);
  render(words);
  EXPECT_EQ(range()["skipped"], "1-4");
  // A picture that cannot be read must be rendered again.
  write("a.02.exr", "v");
  render(words);
  EXPECT_EQ(range()["done"], "2");
  // --skip-existing also works for a single frame.
  const Words one = render_words({"--skip-existing"});
  render(one);
  EXPECT_NE(render(one).err.find("skipped"), std::string::npos);
}

// A full disk or an interrupted copy may truncate files.
TEST_F(Range, TruncatedFramesAreRenderedAgain) {
  const Words alone = render_words({"--driver", "adaptive", "--spp", "4", "--skip-existing"});
  const auto expect_again = [&](const Words& words, const std::string& name,
                                std::initializer_list<double> shares) {
    ASSERT_NE(render(words).err.find("skipped"), std::string::npos) << name;
    for (const double share : shares) {
      const uintmax_t size = fs::file_size(path(name));
      const auto cut = share <= 1 ? uintmax_t(share * double(size - 1)) : uintmax_t(share);
      fs::resize_file(path(name), cut);
      const RunResult result = render(words);
      EXPECT_EQ(result.err.find("skipped"), std::string::npos) << name << " cut to " << cut;
      // The sizes vary slightly, because the files contain times and dates.
      EXPECT_NEAR(double(fs::file_size(path(name))), double(size), 64.0 + 0.05 * double(size))
          << name;
    }
  };
  Words words = alone;
  Words names = {"out.exr", "layers.exr", "a.png", "a.jpg",  "h.png",
                 "h.exr",   "t.json",     "t.png", "r.json", "r.html"};
  for (const std::string& name : names) {
    const Words option = {name[0] == 'h'   ? "--heatmap"
                          : name[0] == 't' ? "--tree"
                          : name[0] == 'r' ? "--report"
                                           : "-o"};
    if (name != "out.exr") words = words + option + Words{path(name)};
  }
  render(words);
  // The first file of each kind is cut at several places, and the others only at the end.
  for (const std::string& name : names) {
    const bool first = name == "out.exr" || name[0] == 'a' || name == "t.json" || name == "r.html";
    if (first) {
      expect_again(words, name, {0, 60, 0.5, 1});
    } else {
      expect_again(words, name, {1});
    }
  }

  const Words shots = alone + Words{"--snapshots", path("shots"), "--snapshot-at", "first"};
  fs::remove(path("out.exr"));
  render(shots);
  expect_again(shots, "shots/refinement.gif", {0.5, 1});
  expect_again(shots, "shots/000_first.png", {1});
}

TEST_F(Range, InterruptWritesTheFrameAndListsTheRest) {
  Process process(endless({"--size", "256x256", "-o", path("a.#.png"), "-o", path("a.#.jpg")}),
                  {.folder = folder_.path()});
  ASSERT_TRUE(process.wait_until_busy("loaded in", 0.2 * kSanitizerSlowdown))
      << process.error_so_far();
  process.send(SIGINT);
  const RunResult result = process.wait();
  EXPECT_EQ(result.exit_code, 130) << result.describe();
  EXPECT_NE(result.err.find("1 stopped (1), 3 left: 2-4"), std::string::npos) << result.err;
  EXPECT_EQ(range()["stopped"], "1");
  EXPECT_EQ(range()["left"], "2-4");
  EXPECT_EQ(range()["exit_code"], 130);
  EXPECT_EQ(files(), (Words{"a.1.exr", "a.1.jpg", "a.1.png", "range.json", "scene.glb"}));

  // In every format, the picture of a stopped frame must count as incomplete.
  for (const char* format : {"exr", "png", "jpg"}) {
    const Words again = {"render",
                         scene(),
                         "-o",
                         path(std::string("a.#.") + format),
                         "--size",
                         "8x8",
                         "--spp",
                         "1",
                         "--frames",
                         "1",
                         "--skip-existing",
                         "--range-report",
                         path("range.json")};
    render(again);
    EXPECT_EQ(range()["done"], "1") << format;
    render(again);
    EXPECT_EQ(range()["skipped"], "1") << format;
  }
}

// The animation has the frames that exist and have the size of the range.
TEST_F(Range, ReportsAsAPage) {
  const Words page = {"--range-report", path("range.html"), "-o", path("a.#.png")};
  const auto expect_parts = [&](const Words& parts) {
    const std::string text = read_text(path("range.html"));
    for (const std::string& part : parts) EXPECT_NE(text.find(part), std::string::npos) << part;
  };
  render(turn(page + Words{"--frames", "1-2"}));
  expect_parts({"scene.glb", "2 rendered", "data:image/gif;base64,", "Frames 1-2 at 25", "<svg",
                "turntable", "--frames 1-2"});
  fs::create_directory(path("a.03.exr"));
  const RunResult failed = run(turn(page + Words{"--frames", "1-3", "--skip-existing"}));
  EXPECT_EQ(failed.exit_code, 1) << failed.describe();
  expect_parts({"2 skipped", "1 failed (3)", "a.03.exr", "Frames 1-2 at 25"});
  render(turn(page + Words{"--frames", "4", "--size", "12x8"}));
  fs::remove(path("a.03.exr"));
  const RunResult odd = run(turn(page + Words{"--frames", "1-4", "--skip-existing"}));
  EXPECT_EQ(odd.exit_code, 0) << odd.describe();
  expect_parts({"Frames 1-3 at 25", "1 frame could not be shown"});
  // Denoised frames are shown denoised, also if only some of them have been.
  render(turn(page + Words{"--frames", "1-2", "--denoise", "--spp", "16"}));
  expect_parts({"Frames 1-2 at 25 frames per second, denoised."});
  render(range_words({"-o", path("p.#.exr"), "--frames", "1-2", "--part", "1/2", "--range-report",
                      path("range.html"), "--turntable", "4"}));
  EXPECT_EQ(read_text(path("range.html")).find("image/gif"), std::string::npos);
}

TEST_F(Range, EveryFrameHasItsTimeLimit) {
  const RunResult result = run(endless(
      {"--size", "256x256", "--time-limit", "0.05", "--driver", "bisection", "--frames", "1-3"}));
  EXPECT_EQ(result.exit_code, 0) << result.describe();
  EXPECT_EQ(range()["done"], "1-3");
  // With --resume, the frame counts as unfinished, but the range must still continue.
  const RunResult resumable = run(endless({"--size", "256x256", "--time-limit", "0.05", "--frames",
                                           "1-2", "--resume", "-o", path("b.#.exr")}));
  EXPECT_EQ(resumable.exit_code, 130) << resumable.describe();
  EXPECT_EQ(range()["stopped"], "1-2");
  EXPECT_TRUE(fs::exists(path("a.1.exr.checkpoint")));
  EXPECT_TRUE(fs::exists(path("a.2.exr.checkpoint")));
}

// After a kill, finished frames must not be repeated. The interrupted frame must be resumed and
// must have the same bits.
TEST_F(Range, KilledRangeContinues) {
  const Words words = {"render",      scene(), "-o",       path("a.#.exr"),  "--size",
                       "160x160",     "--spp", "32",       "--bucket-size",  "8",
                       "--turntable", "3",     "--resume", "--skip-existing"};
  {
    Process process(words, {.folder = folder_.path()});
    ASSERT_TRUE(process.wait_until_busy("frame 2 (2 of 3)", 0.1 * kSanitizerSlowdown));
    process.send(SIGKILL);
    process.wait();
  }
  ASSERT_TRUE(fs::exists(path("a.1.exr")));
  const auto before = fs::last_write_time(path("a.1.exr"));
  const RunResult result = render(words);
  EXPECT_NE(result.err.find("frame 1 (1 of 3) is skipped"), std::string::npos) << result.err;
  EXPECT_EQ(fs::last_write_time(path("a.1.exr")), before);
  EXPECT_EQ(files(), (Words{"a.1.exr", "a.2.exr", "a.3.exr", "scene.glb"}));
  render({"render", scene(), "-o", path("alone.exr"), "--size", "160x160", "--spp", "32",
          "--bucket-size", "8", "--turntable", "2/3"});
  EXPECT_EQ(first_difference(read_exr(path("a.2.exr")), read_exr(path("alone.exr"))), "");
}

TEST_F(Range, ProgressNamesTheFrame) {
  const Words words = turn({"--size", "160x160", "--spp", "64", "--progress-file", path("p.json")});
  const RunResult result = render(words);
  EXPECT_NE(result.err.find("rendering frame 3 (3 of 4) "), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("frames: 4 rendered"), std::string::npos) << result.err;
  const nlohmann::json progress = read_json("p.json");
  EXPECT_EQ(progress["state"], "done");
  EXPECT_EQ(progress["done"], 1.0);
  EXPECT_EQ(progress["samples"], 4 * 160 * 160 * 64);
  EXPECT_EQ(progress["frame"]["number"], 4);
  EXPECT_EQ(progress["frame"]["index"], 4);
  EXPECT_EQ(progress["frame"]["count"], 4);
  EXPECT_EQ(render(words + Words{"--quiet"}).err, "");
}

TEST_F(Range, ReleasesTheMemoryOfEachFrame) {
  const Words words = {"render",   scene(),     "-o",       path("a.#.png"), "--size",
                       "200x200",  "--spp",     "1",        "--turntable",   "12",
                       "--driver", "bisection", "--report", path("r.#.json")};
  render(words);
  const auto reserved = [&](const std::string& name) {
    return read_json(name)["memory"]["most_reserved_bytes"].get<double>();
  };
  EXPECT_LT(reserved("r.12.json"), 1.01 * reserved("r.1.json"));
}

TEST_F(Range, FarmExplainsHowToRenderARange) {
  expect_failure({"farm", scene(), "-o", path("a.####.exr"), "--parts", "2", "--frames", "1-10"}, 2,
                 {"--frames", "render --frames"});
  write("turn.json", R"({"turntable": "8"})");
  expect_failure(
      {"farm", scene(), "-o", path("a.exr"), "--parts", "2", "--settings", path("turn.json")}, 2,
      {"--turntable"});
}

}  // namespace
}  // namespace emberline::test
