// Tests --texture-memory, which keeps textures in a file instead of memory. This must not change
// the picture.
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "cli/command_test.h"
#include "io/image/output.h"
#include "renderer/core/byte_image.h"
#include "support/embedded_images.h"

namespace emberline::test {
namespace {

class TextureMemory : public CommandTest {
 protected:
  static constexpr int kSide = 250;                              // not a multiple of the tile size
  static constexpr uint64_t kMap = uint64_t(3) * kSide * kSide;  // the bytes of each map

  // Writes a scene whose floor and lamp use three noise maps. One of them is a normal map. Returns
  // its path.
  std::string textured() {
    GltfBuilder gltf = lamp_scene();
    uint32_t state = 1;
    const auto map = [&] {
      std::vector<uint8_t> bytes(kMap);
      for (uint8_t& b : bytes) b = uint8_t((state = state * 1664525u + 1013904223u) >> 24);
      const ByteImage image{kSide, kSide, 3, std::move(bytes)};
      return nlohmann::json{
          {"index", add_texture(gltf, emberline::encode_image(image, "png", "map.png"))}};
    };
    nlohmann::json& materials = gltf.root["materials"];
    const nlohmann::json colour = map(), normal = map(), emission = map();
    materials[0]["pbrMetallicRoughness"]["baseColorTexture"] = colour;
    materials[0]["normalTexture"] = normal;
    materials[1]["emissiveTexture"] = emission;
    return gltf.write_glb(path("textured.glb"));
  }
  ExrPicture picture(const Words& more) {
    const Words words = {"render", textured(), "-o", path("out.exr"), "--size",
                         "32x24",  "--spp",    "16", "--max-depth",   "3"};
    render(words + Words{"--report", path("r.json")} + more);
    return read_exr(path("out.exr"));
  }
};

TEST_F(TextureMemory, ThePictureHasTheSameBits) {
  for (const Words& driver : {Words{"--driver", "bucket"}, Words{"--driver", "bisection"},
                              Words{"--driver", "adaptive", "--unbiased"}}) {
    const ExrPicture resident = picture(driver);
    EXPECT_EQ(read_json("r.json")["memory"]["texture_file_bytes"], 0u);
    EXPECT_GE(read_json("r.json")["memory"]["texture_bytes"], 3 * kMap);
    for (const char* threads : {"1", "3"}) {
      const ExrPicture mapped =
          picture(driver + Words{"--threads", threads, "--texture-memory", "1K"});
      EXPECT_EQ(first_difference(resident, mapped), "") << driver[1] << ", threads: " << threads;
      EXPECT_EQ(read_json("r.json")["memory"]["texture_file_bytes"], 3 * kMap);
      EXPECT_LT(read_json("r.json")["memory"]["texture_bytes"], kMap);
    }
  }
}

// Two maps are in memory when the third map exceeds the limit. Then all three must be moved to the
// file.
TEST_F(TextureMemory, LimitsAllTexturesTogether) {
  const auto in_file = [&](uint64_t limit) {
    picture({"--texture-memory", std::to_string(limit)});
    return read_json("r.json")["memory"]["texture_file_bytes"].get<uint64_t>();
  };
  EXPECT_EQ(in_file(3 * kMap), 0u);
  EXPECT_EQ(in_file(3 * kMap - 1), 3 * kMap);
}

// Textures in the file must not count towards --memory-limit.
TEST_F(TextureMemory, DoesNotCountAgainstTheMemoryLimit) {
  const auto reserved = [&](const Words& more) {
    picture(Words{"--threads", "1"} + more);
    return read_json("r.json")["memory"]["most_reserved_bytes"].get<double>();
  };
  EXPECT_LT(reserved({"--texture-memory", "1K"}), reserved({}) - 1.5 * double(kMap));
}

TEST_F(TextureMemory, UnusableTemporaryFolderIsReported) {
  const Words words = {"render", textured(), "-o", path("no.exr"), "--texture-memory", "1K"};
  expect_failure(words, 1, {"cannot store textures", path("none"), "TMPDIR"},
                 {.environment = {{"TMPDIR", path("none")}}});
  // A limit on the size of files simulates a full disk.
  expect_failure(words, 1, {"cannot store textures", "File too large"},
                 {.environment = {{"TMPDIR", folder_.path()}}, .file_size_limit = kMap / 2});
  // Two maps must be moved, but the file has space for only one. When the third map is loaded, the
  // command tries to move the remaining maps again.
  const Words some = {"render", textured(),         "-o",  path("no.exr"), "--threads",
                      "1",      "--texture-memory", "300K"};
  expect_failure(some, 1, {"cannot store textures", "File too large"},
                 {.environment = {{"TMPDIR", folder_.path()}}, .file_size_limit = kMap * 3 / 2});
}

// If all textures fit into memory, the temporary folder must not be used.
TEST_F(TextureMemory, SmallTexturesNeedNoTemporaryFile) {
  render({"render", textured(), "-o", path("a.exr"), "--size", "8x8", "--spp", "1",
          "--texture-memory", "1G"},
         {.environment = {{"TMPDIR", path("none")}}});
}

TEST_F(TextureMemory, KilledRunLeavesNoFiles) {
  const std::string folder = path("temporary");
  std::filesystem::create_directory(folder);
  Process process({"render", textured(), "-o", path("long.exr"), "--spp", "1000000",
                   "--texture-memory", "1K", "--verbose"},
                  {.folder = folder_.path(), .environment = {{"TMPDIR", folder}}});
  ASSERT_TRUE(process.wait_for_error("loaded in", 30 * kSanitizerSlowdown))
      << process.error_so_far();
  process.send(SIGKILL);
  EXPECT_EQ(process.wait().signal, SIGKILL);
  EXPECT_TRUE(std::filesystem::is_empty(folder));
}

}  // namespace
}  // namespace emberline::test
