// Tests which files a scene can make the program read (those in its own folder and below it), and
// how much of them is read.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "failure/bad_input.h"
#include "io/files/input_file.h"
#include "io/gltf/gltf_file.h"
#include "io/gltf/scene_files.h"
#include "support/process_memory.h"

namespace emberline {
namespace {

namespace fs = std::filesystem;
using test::expect_input_error;
using test::GltfBuilder;
using test::TempFolder;

class Resources : public ::testing::Test {
 protected:
  // Writes a scene in "scenes/" with a triangle whose buffer is at `uri`, and returns the scene's
  // path.
  std::string scene(const std::string& uri) {
    GltfBuilder gltf;
    gltf.add_triangle();
    const std::string path = gltf.write_gltf(folder_ / "scenes/a.gltf");
    nlohmann::json root = nlohmann::json::parse(test::read_bytes(path));
    fs::copy_file(folder_ / ("scenes/" + root["buffers"][0]["uri"].get<std::string>()),
                  folder_ / "outside.bin", fs::copy_options::overwrite_existing);
    root["buffers"][0]["uri"] = uri;
    test::write_text(path, root.dump());
    return path;
  }

  TempFolder folder_;
};

TEST_F(Resources, OutsideTheFolderAreRefused) {
  for (const char* uri : {"../outside.bin", "%2e%2e/outside.bin", "..%2Foutside.bin",
                          "x/../../outside.bin", "../../../../../../../../etc/passwd"}) {
    expect_input_error(scene(uri),
                       {"#/buffers/0/uri", "points outside the scene's folder", "resource-root"});
  }
  expect_input_error(scene("/etc/passwd"), {"#/buffers/0/uri", "absolute path"});
  expect_input_error(scene("file:///etc/passwd"), {"#/buffers/0/uri", "not relative"});
}

// Some writers do not escape names properly, and some names come from other operating systems.
TEST_F(Resources, UnescapedNamesAreFound) {
  fs::create_directories(folder_ / "scenes/sub dir");
  const std::pair<const char*, const char*> names[] = {{"example 10%.bin", "example 10%.bin"},
                                                       {"a%20b.bin", "a%20b.bin"},
                                                       {"%zz%2.bin", "%zz%2.bin"},
                                                       {"a%20b 5%25.bin", "a b 5%.bin"},
                                                       {"a%20b 10%.bin", "a b 10%.bin"},
                                                       {"a\\b.bin", "a\\b.bin"},
                                                       {"sub dir\\b.bin", "sub dir/b.bin"},
                                                       {".\\sub%20dir\\b.bin", "sub dir/b.bin"},
                                                       {"sub dir%5Cb%.bin", "sub dir%5Cb%.bin"},
                                                       {"sub%20dir%5Cb.bin", "sub dir/b.bin"}};
  for (const auto& [uri, file] : names) {
    const std::string path = scene(uri);
    const std::string target = folder_ / ("scenes/" + std::string(file));
    fs::rename(folder_ / "outside.bin", target);
    EXPECT_EQ(load_gltf(path, {}).meshes.size(), 1u) << uri;
    EXPECT_EQ(scene_files(path).back(), fs::path(target)) << uri;
    fs::remove(target);
  }
  // The name with its escapes decoded is tried first, then the literal name, then the name with "/"
  // for "\".
  const auto vertices = [&](const std::string& path) {
    return load_gltf(path, {}).meshes.at(0).positions.at(1).x;
  };
  const auto expect_first = [&](const char* uri, const std::string& first,
                                const std::string& other) {
    const std::string path = scene(uri);
    fs::copy_file(folder_ / "outside.bin", folder_ / ("scenes/" + first));
    const std::vector<float> zeros(20, 0.5f);
    test::write_bytes(folder_ / ("scenes/" + other), zeros.data(), 80);
    EXPECT_EQ(vertices(path), 1.0f) << uri;
    fs::remove(folder_ / ("scenes/" + first));
    fs::remove(folder_ / ("scenes/" + other));
  };
  expect_first("c%20d.bin", "c d.bin", "c%20d.bin");
  expect_first("sub dir\\c.bin", "sub dir\\c.bin", "sub dir/c.bin");
  // No spelling may lead out of the folder.
  for (const char* uri : {"..\\outside.bin", "%2e%2e\\outside.bin", "..%5Coutside.bin",
                          "sub dir\\..\\..\\outside.bin"}) {
    expect_input_error(scene(uri), {"#/buffers/0/uri", "points outside the scene's folder"});
  }
  expect_input_error(scene("\\etc\\passwd"), {"#/buffers/0/uri", "absolute path"});
  expect_input_error(scene("C:\\a.bin"), {"#/buffers/0/uri", "not relative"});
  expect_input_error(scene("gone 10%.bin"), {"#/buffers/0/uri", "malformed % escape"});
  expect_input_error(scene("sub\\gone.bin"), {"#/buffers/0/uri", "file not found"});
}

TEST_F(Resources, LinksAreResolvedBeforeTheCheck) {
  const std::string path = scene("link.bin");
  ASSERT_EQ(::symlink("../outside.bin", (folder_ / "scenes/link.bin").c_str()), 0);
  expect_input_error(path, {"points outside the scene's folder", "outside.bin"});
  fs::create_directory(folder_ / "scenes/sub");
  fs::rename(folder_ / "outside.bin", folder_ / "scenes/sub/inside.bin");
  fs::remove(folder_ / "scenes/link.bin");
  ASSERT_EQ(::symlink("sub/inside.bin", (folder_ / "scenes/link.bin").c_str()), 0);
  EXPECT_EQ(load_gltf(path, {}).meshes.size(), 1u);
  fs::remove(folder_ / "scenes/link.bin");
  ASSERT_EQ(::symlink("link.bin", (folder_ / "scenes/link.bin").c_str()), 0);
  expect_input_error(path, {"cannot access the file link.bin"});
  expect_input_error(scene(std::string(5000, 'a')), {"cannot access the file"});
}

TEST_F(Resources, ResourceRootAllowsMoreFiles) {
  const std::string path = scene("../outside.bin");
  const SceneDescription read = load_gltf(path, {.resource_root = folder_.path().string()});
  ASSERT_EQ(read.files.size(), 2u);
  EXPECT_EQ(read.files[0].identity, *file_identity(path));
  EXPECT_EQ(read.files[1].identity, *file_identity(folder_ / "outside.bin"));
  EXPECT_EQ(load_gltf(path, {.resource_root = folder_.path().string() + "/"}).meshes.size(), 1u);
  expect_input_error(path, {"points outside"}, {.resource_root = folder_ / "scenes"});
  expect_input_error(path, {"points outside"}, {.resource_root = folder_ / "scene"});
}

// Of a 3 GB buffer only the triangle's bytes are read, and the rest costs nothing.
TEST_F(Resources, OnlyUsedPartsOfBuffersAreRead) {
  const std::string path = scene("large.bin");
  fs::rename(folder_ / "outside.bin", folder_ / "scenes/large.bin");
  constexpr uint64_t kSize = uint64_t(3) << 30;
  ASSERT_EQ(::truncate((folder_ / "scenes/large.bin").c_str(), off_t(kSize)), 0);
  nlohmann::json root = nlohmann::json::parse(test::read_bytes(path));
  root["buffers"][0]["byteLength"] = kSize;
  root["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", 0}, {"byteLength", kSize}});
  test::write_text(path, root.dump());
  const auto budget = std::make_shared<MemoryBudget>(uint64_t(64) << 20);
  LoadProgress progress({}, {}, {.memory = budget, .timeout_s = {}, .scene = {}});
  const test::ProcessMemory before = test::ProcessMemory::now();
  EXPECT_EQ(load_gltf(path, {}, progress).meshes.size(), 1u);
  EXPECT_LT(budget->peak(), uint64_t(1) << 20);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // sanitizers track the memory
  EXPECT_LT((test::ProcessMemory::now() - before).resident, double(16 << 20));
#endif
}

}  // namespace
}  // namespace emberline
