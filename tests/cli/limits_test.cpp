// Tests --memory-limit and --load-timeout. The command must refuse to use too much memory before it
// allocates the memory, and reservations must match the memory that is used.
#include <sys/stat.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <regex>

#include "cli/command_test.h"
#include "io/image/output.h"
#include "renderer/core/byte_image.h"
#include "support/embedded_images.h"

namespace emberline::test {
namespace {

class Limits : public CommandTest {
 protected:
  // Writes a scene with a visible grid of n x n vertices. Returns its path.
  std::string grid(int n) {
    GltfBuilder gltf = lamp_scene();
    std::vector<float> positions;
    std::vector<uint32_t> indices;
    for (int y = 0; y < n; ++y) {
      for (int x = 0; x < n; ++x) {
        positions.insert(positions.end(), {float(x) / float(n), 0.1f, float(y) / float(n)});
        if (x + 1 == n || y + 1 == n) continue;
        const auto at = uint32_t(y * n + x), below = at + uint32_t(n);
        for (const uint32_t i : {at, below, at + 1, at + 1, below, below + 1}) indices.push_back(i);
      }
    }
    const int points = gltf.add_accessor<float>("VEC3", positions);
    gltf.add_mesh_node(
        gltf.add_mesh({{"attributes", {{"POSITION", points}}},
                       {"indices", gltf.add_accessor<uint32_t>("SCALAR", indices)}}));
    return gltf.write_glb(path("grid.glb"));
  }

  // Writes a picture that OpenImageIO reads. Returns its path.
  std::string tiff() {
    write_floats(path("grey.tif"), 8, 4, 3, std::vector<float>(size_t(8) * 4 * 3, 1.0f));
    return path("grey.tif");
  }

  struct Figures {
    double reserved, peak, film;
  };
  Figures figures(const std::string& file, const Words& more) {
    render(Words{"render", file, "-o", path("out.exr"), "--spp", "2", "--threads", "2", "--report",
                 path("r.json")} +
           more);
    const nlohmann::json memory = read_json("r.json")["memory"];
    return {memory["most_reserved_bytes"], memory["peak_rss_bytes"], memory["film_bytes"]};
  }
};

// If Embree fails to create a device, the next device that it creates hangs when it is released.
// The command must not hang in this case.
TEST_F(Limits, ReportsTooLittleMemoryForEmbree) {
  if (kSanitized) GTEST_SKIP() << "a sanitizer needs more itself";
  for (const uint64_t limit : {64, 96}) {
    expect_failure(render_words(), 1, {}, {.data_limit = limit << 20});
  }
}

// With this limit, the dependencies of the image library would abort or hang if they were loaded.
TEST_F(Limits, ReportsTooLittleMemoryForTheImageLibrary) {
  if (kSanitized) GTEST_SKIP() << "a sanitizer needs more itself";
  expect_failure({"compare", tiff(), path("grey.tif")}, 1, {"ulimit"},
                 {.data_limit = uint64_t(600) << 20});
}

// The test damages the library of a copy of the program, which is in a separate folder.
TEST_F(Limits, ReportsADamagedImageLibrary) {
  namespace fs = std::filesystem;
  if (kSanitized) GTEST_SKIP() << "AddressSanitizer's program has it linked";
  const fs::path program = fs::path(EMBERLINE_BINARY), folder = path("installed");
  const fs::path name = "lib/libemberline_images.so", library = folder / name;
  fs::create_directories(folder / "bin");
  fs::create_directories(folder / "lib");
  fs::copy_file(program, folder / "bin/emberline");
  fs::copy_file(program.parent_path().parent_path() / name, library);
  const auto command = [&](const std::string& words) {
    return "'" + (folder / "bin/emberline").string() + "' " + words + " 2>'" + path("said") + "'";
  };
  const std::string needs_it = command("compare '" + tiff() + "' '" + path("grey.tif") + "'");
  EXPECT_EQ(std::system(needs_it.c_str()), 0);
  const auto expect_damaged = [&](const std::string& part) {
    const int status = std::system(needs_it.c_str());
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) != 0) << status;
    const std::vector<uint8_t> log_bytes = read_bytes(path("said"));
    const std::string text(log_bytes.begin(), log_bytes.end());
    EXPECT_EQ(std::ranges::count(text, '\n'), 1) << text;
    EXPECT_NE(text.find(part), std::string::npos) << text;
  };
  const uintmax_t whole = fs::file_size(library);
  for (const uintmax_t size : {whole - 1, whole / 2, uintmax_t(100), uintmax_t(10)}) {
    fs::resize_file(library, size);
    expect_damaged("is damaged");
  }
  fs::remove(library);
  ASSERT_EQ(::mkfifo(library.c_str(), 0600), 0);
  expect_damaged("not a regular file");
  // PNG, JPEG and EXR must work without the library, as textures or environments and as pictures.
  GltfBuilder gltf = lamp_scene();
  auto& colour = gltf.root["materials"][0]["pbrMetallicRoughness"];
  colour["baseColorTexture"]["index"] = add_texture(gltf, small_png());
  const ByteImage flat{2, 2, 3, std::vector<uint8_t>(12, 200)};
  gltf.root["materials"][0]["emissiveTexture"]["index"] =
      add_texture(gltf, emberline::encode_image(flat, "jpeg", "flat.jpg"), "image/jpeg");
  write_floats(path("sky.exr"), 8, 4, 3, std::vector<float>(size_t(8) * 4 * 3, 1.0f));
  const std::string render = "render '" + gltf.write_glb(path("textured.glb")) + "' --env '" +
                             path("sky.exr") + "' --size 8x8 --spp 1 --quiet";
  std::string pictures;
  for (const char* file : {"a.png", "a.jpg", "a.exr"}) pictures += " -o '" + path(file) + "'";
  pictures += " --exr-compression dwaa --report '" + path("a.html") + "'";
  EXPECT_EQ(std::system(command(render + pictures).c_str()), 0);
}

TEST_F(Limits, ReservedMemoryMatchesUsedMemory) {
  if (kSanitized) GTEST_SKIP() << "a sanitizer's own memory is many times ours";
  const Words small = {"--size", "16x16"};
  const std::string plain = scene(), large = grid(500);
  const Figures none = figures(plain, small);
  const Figures no_picture = figures(plain, small + Words{"-o", path("p.png")});
  const struct {
    const char* what;
    std::string file;
    const Figures& before;
    Words words;
  } rows[] = {
      {"triangles", large, none, small},
      {"a film", plain, none, {"--size", "800x600", "--driver", "bisection", "--spp", "1"}},
      {"an adaptive film", plain, none, {"--size", "500x400", "--driver", "adaptive"}},
      {"a picture",
       plain,
       no_picture,
       {"--size", "2700x2000", "--spp", "1", "--integrator", "albedo", "-o", path("p.png")}},
  };
  for (const auto& row : rows) {
    const Figures f = figures(row.file, row.words);
    const double taken = f.peak - row.before.peak, reserved = f.reserved - row.before.reserved;
    EXPECT_GT(reserved, 30e6) << row.what;
    // The memory of two equal runs differs by up to 8 MB.
    EXPECT_LT(taken, 1.1 * reserved + 8e6) << row.what;
    EXPECT_LT(reserved, 3.0 * taken + 8e6) << row.what;
  }
  for (const char* driver : {"bisection", "adaptive"}) {
    const Figures f = figures(plain, {"--size", "300x200", "--driver", driver});
    EXPECT_LE(f.film - none.film, f.reserved - none.reserved) << driver;
  }
}

// If a frame is stopped before every pixel has a sample, two things happen at the same time: the
// filled picture is written with its layers and lights, and the frame is saved.
TEST_F(Limits, ReservesMemoryOfAFrameStoppedInItsFirstPass) {
  if (kSanitized) GTEST_SKIP() << "a sanitizer's own memory is many times ours";
  const Words layers = {"--aov", "direct,indirect,emission,transmission,reflection,environment"};
  const Figures none = figures(scene(), {"--size", "16x16"});
  for (const Words& more : {Words{}, layers, Words{"--light-groups"},
                            layers + Words{"--light-groups"}, layers + Words{"--resumable"}}) {
    const Figures f = figures(
        scene(),
        Words{"--size", "800x640", "--driver", "bisection", "--time-limit", "0.001"} + more);
    EXPECT_LT(f.peak - none.peak, 1.05 * (f.reserved - none.reserved) + 8e6);
    EXPECT_LT(f.reserved - none.reserved, 1.6 * (f.peak - none.peak) + 8e6);
  }
}

// With these settings, most channels of a tile are ids of --cryptomatte. The encoder for DWA, which
// is in a library, allocates further memory.
TEST_F(Limits, ReservesMemoryOfMattes) {
  if (kSanitized) GTEST_SKIP() << "a sanitizer's own memory is many times ours";
  const Words mattes = {"--cryptomatte", "object,material,asset", "--cryptomatte-levels", "32"};
  const Words tiny = {"--size", "16x16"};
  const Words stopped = {"--driver", "bisection", "--spp", "4096", "--time-limit", "0.1"};
  const Words small = {"--size", "300x240"}, large = {"--size", "500x400"};
  for (const Words& more :
       {small + mattes + stopped + Words{"--bucket-size", "128"},
        small + mattes + stopped + Words{"--denoise"}, small + mattes + Words{"--denoise"},
        large + stopped + Words{"--exr-compression", "dwab"},
        large + Words{"--exr-compression", "dwab"},
        small + mattes + stopped + Words{"--exr-parts", "layers", "--exr-compression", "dwab"}}) {
    SCOPED_TRACE(testing::PrintToString(more));
    // Memory for loading the library of the encoder does not count as memory of the frame.
    const bool dwa = std::ranges::find(more, "dwab") != more.end();
    const Figures none = figures(scene(), dwa ? tiny + Words{"--exr-compression", "dwab"} : tiny);
    const Figures f = figures(scene(), more);
    EXPECT_LT(f.peak - none.peak, f.reserved - none.reserved + 8e6);
    EXPECT_LT(f.reserved - none.reserved, 1.6 * (f.peak - none.peak) + 8e6);
  }
}

// The denoiser needs two halves of the samples. While a tile is written, it therefore contains each
// light three times.
TEST_F(Limits, ReservesMemoryOfTilesWithLightsByHalves) {
  if (kSanitized) GTEST_SKIP() << "a sanitizer's own memory is many times ours";
  GltfBuilder gltf = lamp_scene();
  for (int i = 0; i < 60; ++i) {
    const int shines = gltf.push(
        "materials", {{"name", "lamp " + std::to_string(i)}, {"emissiveFactor", {0.1, 0.1, 0.1}}});
    add_quad(gltf, {-1.5f + 0.05f * float(i), 0.2f, -1}, {0.04f, 0, 0}, {0, 0.1f, 0}, shines);
  }
  const std::string lamps = gltf.write_glb(path("lamps.glb"));
  const Words lights = {"--light-groups", "--aov", "denoising"};
  const Figures none = figures(lamps, lights + Words{"--size", "16x16"});
  const Figures f =
      figures(lamps, lights + Words{"--size", "192x96", "--bucket-size", "96", "--spp", "1"});
  EXPECT_LT(f.peak - none.peak, f.reserved - none.reserved + 8e6);
  EXPECT_LT(f.reserved - none.reserved, 2.2 * (f.peak - none.peak) + 8e6);
}

// Each thread of `merge` has ids and lights in its film and in its output buffers. The encoder for
// DWA allocates further memory.
TEST_F(Limits, ReservesMemoryOfMergedMattesAndLights) {
  if (kSanitized) GTEST_SKIP() << "a sanitizer's own memory is many times ours";
  const auto merged = [&](const Words& frame) {
    Words merge = {"merge", "-o", path("out.exr"), "--threads", "2", "--report", path("r.json")};
    for (const std::string range : {"0-1", "1-2"}) {
      render(Words{"render", scene(), "-o", path("out.exr"), "--sample-range", range} + frame);
      merge.push_back(path("out.exr.samples-" + range + ".checkpoint"));
    }
    render(merge);
    const nlohmann::json memory = read_json("r.json")["memory"];
    return Figures{memory["most_reserved_bytes"], memory["peak_rss_bytes"], 0};
  };
  const Words large = {"--size", "256x128", "--bucket-size", "128"};
  const Words mattes = {"--cryptomatte", "object,material,asset", "--cryptomatte-levels", "32"};
  const Words lights = {"--light-groups", "--aov", "denoising"};
  const Words lossy = {"--exr-compression", "dwab"};
  const Figures none = merged({"--size", "16x16", "--bucket-size", "8"});
  for (const Words& more : {mattes, lights, lossy}) {
    SCOPED_TRACE(more.front());
    const Figures f = merged(large + more);
    EXPECT_LT(f.peak - none.peak, f.reserved - none.reserved + 8e6);
    EXPECT_LT(f.reserved - none.reserved, 2.2 * (f.peak - none.peak) + 8e6);
  }
}

// With millions of buckets, the lists of buckets need considerable memory.
TEST_F(Limits, ReservesMemoryOfBucketLists) {
  const Words frame = {"render", scene(),         "-o", path("out.exr"), "--spp",
                       "1",      "--bucket-size", "1"};
  expect_failure(frame + Words{"--size", "4096x4096", "--memory-limit", "400M"}, 2,
                 {"--bucket-size", "16777216 buckets", "--memory-limit"});
  if (kSanitized) GTEST_SKIP() << "a sanitizer's own memory is many times ours";
  const Figures none = figures(scene(), {"--size", "16x16"});
  const Figures f =
      figures(scene(), {"--size", "2048x1024", "--bucket-size", "1", "--time-limit", "0.001"});
  EXPECT_LT(f.peak - none.peak, f.reserved - none.reserved + 8e6);
}

TEST_F(Limits, AFrameThatIsTooLargeIsRefusedBeforeTheLoad) {
  for (const Words& more : {Words{"-o", path("a.png")}, Words{"--driver", "bisection"},
                            Words{"--driver", "adaptive"}, Words{"--heatmap", path("h.png")}}) {
    expect_failure(render_words(Words{"--size", "65536x65536", "--memory-limit", "1G"} + more), 2,
                   {"--size", "65536x65536", "limit of 1 GiB", "--memory-limit"});
  }
}

// The limit applies to all memory, including the working memory of each thread.
TEST_F(Limits, BucketsThatAreTooLargeAreRefusedBeforeTheLoad) {
  for (const auto& [driver, limit] : {std::pair("bucket", "60"), std::pair("bisection", "120")}) {
    const Words words = {"--size",   "1024x1024", "--memory-limit", limit + std::string("M"),
                         "--driver", driver,      "--threads",      "4"};
    expect_failure(
        render_words(words + Words{"--bucket-size", "512"}), 2,
        {"--bucket-size, --threads: working on 4 buckets of 512x512 pixels at once needs",
         "limit of " + std::string(limit) + " MiB", "--memory-limit"});
    render(render_words(words));
  }
}

TEST_F(Limits, ASceneThatIsTooLargeIsRefused) {
  const std::string file = grid(300);
  for (const char* command : {"render", "info"}) {
    Words words = {command, file, "--memory-limit", "2M"};
    if (words[0] == "render") words = words + Words{"-o", path("out.exr")};
    expect_failure(words, 3, {"grid.glb", "of the limit of 2 MiB is left", "--memory-limit"});
  }
}

TEST_F(Limits, ASurveyThatNeedsTooMuchIsRefused) {
  Words words = {"render",
                 EMBERLINE_SCENES "/cornell_box.glb",
                 "-o",
                 path("out.exr"),
                 "--size",
                 "130x130",
                 "--spp",
                 "1",
                 "--memory-limit",
                 "20M"};
  expect_failure(words, 3, {"--guiding (off needs no memory)", "of the limit of 20 MiB is left"});
  render(words + Words{"--guiding", "off"});
}

// If building the BVH fails, memory is released before the error is reported. The error must name
// the amount that was left before that.
TEST_F(Limits, ARefusalNamesLessMemoryThanIsNeeded) {
  const std::string file = grid(300);
  const std::regex figures("needs ([0-9.,]+) (Ki|Mi)?B of memory .*but only ([0-9.,]+) (Ki|Mi)?B");
  const auto bytes = [](std::string number, const std::string& unit) {
    std::erase(number, ',');
    return std::stod(number) * (unit == "Ki" ? 1 << 10 : unit == "Mi" ? 1 << 20 : 1);
  };
  int refused_builds = 0;
  for (int limit = 4; limit <= 40; limit += 2) {
    const RunResult result = run({"render", file, "-o", path("out.exr"), "--size", "16x16", "--spp",
                                  "1", "--memory-limit", std::to_string(limit) + "MiB"});
    if (result.exit_code == 0) break;
    std::smatch match;
    ASSERT_TRUE(std::regex_search(result.err, match, figures)) << result.err;
    EXPECT_GT(bytes(match[1], match[2]), bytes(match[3], match[4])) << result.err;
    refused_builds += result.err.find("(bvh)") != std::string::npos;
  }
  EXPECT_GT(refused_builds, 0);
}

TEST_F(Limits, UnitsAreBinaryOrDecimal) {
  for (const auto& [size, shown] :
       {std::pair("1GiB", "1 GiB"), {"1g", "1 GiB"}, {"1GB", "954 MiB"}, {"1000MB", "954 MiB"}}) {
    expect_failure(
        render_words({"-o", path("a.png"), "--size", "65536x65536", "--memory-limit", size}), 2,
        {"limit of " + std::string(shown)});
  }
}

TEST_F(Limits, PicturesThatAreTooLargeAreRefused) {
  render(render_words({"--size", "400x340", "--integrator", "albedo"}));
  const std::string large = path("large.exr");
  std::filesystem::rename(path("out.exr"), large);
  const std::string left = "of the limit of 2 MiB is left";
  expect_failure({"compare", large, large, "--memory-limit", "2M"}, 3, {"large.exr", left});
  expect_failure({"heatmap", large, "-o", path("h.png"), "--memory-limit", "2M"}, 3,
                 {"large.exr", left});
  // With enough memory, both commands must succeed.
  for (const Words& words : {Words{"compare", large, large, "-o", path("d.png")},
                             Words{"heatmap", large, "-o", path("h.png")}}) {
    const RunResult result = run(words + Words{"--memory-limit", "60M"});
    EXPECT_EQ(result.exit_code, 0) << words[0] << ": " << result.err;
  }
  // The command must refuse other pictures in the same way: an environment from an option, an
  // environment from an edit, and a reference.
  write("dim.json",
        nlohmann::json{{"emberline_edits", 1}, {"environment", {{"file", "large.exr"}}}}.dump());
  for (const Words& more : {Words{"--env", large}, Words{"--edits", path("dim.json")}}) {
    expect_failure(render_words(more + Words{"--memory-limit", "2M"}), 3, {"large.exr", left});
  }
  expect_failure({"study", scene(), "-o", path("s"), "--size", "400x340", "--spp", "1",
                  "--reference", large, "--memory-limit", "2M"},
                 3, {"large.exr", left});
}

// A parsed JSON document needs many times as much memory as its file.
TEST_F(Limits, ReservesMemoryOfAnEditsFile) {
  std::string arrays = "[]";
  for (int i = 1; i < 400'000; ++i) arrays += ",[]";
  write("edits.json", R"({"emberline_edits": 1, "lights": [)" + arrays + "]}");
  expect_failure(render_words({"--edits", path("edits.json"), "--memory-limit", "8M"}), 3,
                 {"edits.json", "of the limit of 8 MiB is left"});
}

TEST_F(Limits, AStudyWhoseFramesAreTooLargeIsRefusedBeforeItsFolderIsMade) {
  expect_failure({"study", scene(), "-o", path("s"), "--size", "20000x20000", "--spp", "1",
                  "--reference-spp", "2", "--memory-limit", "1G"},
                 2, {"--size", "20000x20000", "limit of 1 GiB", "--memory-limit"});
}

TEST_F(Limits, LoadTimeoutEndsTheLoad) {
  const std::string file = grid(300);
  expect_failure({"render", file, "-o", path("out.exr"), "--load-timeout", "0.001"}, 3,
                 {"grid.glb", "loading took longer than 1 ms; raise --load-timeout"});
}

}  // namespace
}  // namespace emberline::test
