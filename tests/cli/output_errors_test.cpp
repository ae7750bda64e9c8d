// Tests output that cannot be written. The command must exit with 1, print one line, leave no
// partial file, and leave an existing file of that name unchanged.
#include <fcntl.h>
#include <sys/mount.h>
#include <unistd.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "cli/command_test.h"

namespace emberline::test {
namespace {

class OutputErrors : public CommandTest {
 protected:
  static constexpr const char* kOld = "last night's good frame";
  // With these settings the frame is noisy, so that no format can compress it well.
  const Words kNoisy = {"--look-from", "0,1,0", "--look-at", "0,0,0", "--max-depth", "2"};
};

TEST_F(OutputErrors, MissingFolder) {
  expect_failure(render_words({"-o", path("new/sub/a.exr")}), 1,
                 {"new/sub/a.exr", "does not exist"});
  expect_failure(render_words({"-o", path("new/a.png")}), 1, {"new/a.png", "does not exist"});
  expect_failure(render_words({"-o", path("scene.glb/a.exr")}), 1, {"scene.glb/a.exr"});
}

TEST_F(OutputErrors, OutputIsAFolder) {
  for (const char* name : {"a.exr", "a.png", "a.jpg"}) {
    std::filesystem::create_directories(path(name));
    expect_failure(render_words({"-o", path(name)}), 1, {name, "folder"});
  }
}

TEST_F(OutputErrors, WriteProtectedFolder) {
  scene();
  std::filesystem::create_directories(path("closed"));
  write("closed/a.exr", kOld);
  using std::filesystem::perms;
  const auto readable = perms::owner_read | perms::owner_exec | perms::group_read |
                        perms::group_exec | perms::others_read | perms::others_exec;
  std::filesystem::permissions(path("closed"), readable);
  std::filesystem::permissions(folder_.path(), perms::all);
  for (const char* name : {"closed/a.exr", "closed/b.exr", "closed/b.png"}) {
    expect_failure({"render", scene(), "-o", path(name), "--size", "8x8", "--spp", "1"}, 1, {name},
                   {.unprivileged = true});
  }
  EXPECT_EQ(read_bytes(path("closed/a.exr")).size(), std::string(kOld).size());
  std::filesystem::permissions(path("closed"), perms::owner_all);
}

TEST_F(OutputErrors, WriteProtectedFile) {
  scene();
  std::filesystem::permissions(folder_.path(), std::filesystem::perms::all);
  for (const char* name : {"a.exr", "a.png", "r.json"}) {
    write(name, kOld);
    std::filesystem::permissions(
        path(name), std::filesystem::perms::owner_read | std::filesystem::perms::others_read);
    const Words words = std::string(name) == "r.json"
                            ? Words{"-o", path("b.exr"), "--report", path(name)}
                            : Words{"-o", path(name)};
    expect_failure(Words{"render", scene(), "--size", "8x8", "--spp", "1"} + words, 1,
                   {name, "write-protected"}, {.unprivileged = true});
    const auto bytes = read_bytes(path(name));
    EXPECT_EQ(std::string(bytes.begin(), bytes.end()), kOld);
  }
}

// A limit on the size of files (RLIMIT_FSIZE) simulates a full disk.
TEST_F(OutputErrors, DiskFillsUpDuringTheRender) {
  scene();
  for (const char* name : {"a.exr", "a.png", "a.jpg"}) {
    write(name, kOld);
    expect_failure(
        Words{"render", scene(), "-o", path(name), "--size", "300x300", "--spp", "1", "--quiet"} +
            kNoisy,
        1, {name, "File too large"}, {.file_size_limit = 1500});
    const auto bytes = read_bytes(path(name));
    EXPECT_EQ(std::string(bytes.begin(), bytes.end()), kOld) << name;
  }
}

// If a file cannot be written, the other files must still be written. This must hold for a failure
// during the render, as with the tiles of an EXR, and for a failure at its end. The log and the
// report must name each file that failed.
TEST_F(OutputErrors, WritableOutputsAreStillWritten) {
  for (const char* driver : {"bucket", "adaptive"}) {
    SCOPED_TRACE(driver);
    const bool adaptive = std::string(driver) == "adaptive";
    Words words = {"render",      scene(),       "-o",      path("a.exr"), "-o",
                   path("b.png"), "--size",      "200x200", "--spp",       "4",
                   "--driver",    driver,        "--quiet", "--heatmap",   path("h.png"),
                   "--report",    path("r.json")};
    words = words + kNoisy;
    if (adaptive) {
      words = words +
              Words{"--tree", path("t.json"), "--snapshots", path("s"), "--snapshot-at", "first"};
    }
    // The heatmap and the report fit within the limit, but the pictures do not.
    const RunResult result = run(words, {.file_size_limit = 20000});
    EXPECT_EQ(result.exit_code, 1) << result.describe();
    Words failed;
    for (const std::string& line : result.error_lines()) {
      EXPECT_TRUE(line.starts_with("emberline: error: cannot write " + path(""))) << line;
      EXPECT_TRUE(line.ends_with("File too large")) << line;
      const size_t begin = line.find(path(""));
      failed.push_back(line.substr(begin, line.find(": ", begin) - begin));
    }
    EXPECT_EQ(std::ranges::count(failed, path("a.exr")), 1) << result.err;
    EXPECT_EQ(std::ranges::count(failed, path("b.png")), 1) << result.err;
    const nlohmann::json report = read_json("r.json");
    EXPECT_EQ(report["exit_code"], 1);
    EXPECT_EQ(report["failed_outputs"], failed);
    EXPECT_GT(report["samples"]["total"], 0);
    EXPECT_TRUE(adaptive || std::filesystem::exists(path("h.png")));
    for (const std::string& name : files()) {
      EXPECT_EQ(name.find(".part"), std::string::npos) << name;
      EXPECT_EQ(std::ranges::count(failed, path(name)), 0) << name;
    }
  }
}

TEST_F(OutputErrors, FullFileSystem) {
  scene();
  std::filesystem::create_directories(path("disk"));
  if (::mount("none", path("disk").c_str(), "tmpfs", 0, "size=64k") != 0) {
    GTEST_SKIP() << "needs the right to mount; ADiskThatFillsUp tests the same way";
  }
  write("disk/a.exr", kOld);
  expect_failure(Words{"render", scene(), "-o", path("disk/a.exr"), "--size", "300x300", "--spp",
                       "1", "--quiet"} +
                     kNoisy,
                 1, {"disk/a.exr", "No space left on device"});
  expect_failure(Words{"render", scene(), "-o", path("disk/b.png"), "--size", "300x300", "--spp",
                       "1", "--quiet"} +
                     kNoisy,
                 1, {"disk/b.png", "No space left on device"});
  EXPECT_EQ(read_bytes(path("disk/a.exr")).size(), std::string(kOld).size());
  ::umount(path("disk").c_str());
}

// A typing error must not cost hours of rendering, so paths are checked first. The scene does not
// exist either, but the error names the path. This shows that the path is checked before the scene
// is loaded.
TEST_F(OutputErrors, ReportPathIsCheckedBeforeTheRender) {
  expect_failure(render_words({"--report", path("missing/r.json")}), 1,
                 {"missing/r.json", "does not exist"});
  for (const char* option : {"--report", "-o"}) {
    expect_failure(
        {"render", path("no scene.glb"), "-o", path("out.exr"), option, path("missing/r.exr")}, 1,
        {"missing/r.exr", "does not exist"});
  }
  std::filesystem::create_directories(path("r.json"));
  expect_failure(render_words({"--report", path("r.json")}), 1, {"r.json", "folder"});
}

// The command must recognise a file under every spelling of its path.
TEST_F(OutputErrors, OutputsMayNotReplaceInputsOrEachOther) {
  namespace fs = std::filesystem;
  scene();
  fs::create_directories(path("sub"));
  fs::create_directories(path("shots"));
  fs::create_symlink(".", path("here"));
  write("edits.json", "{}");
  fs::create_hard_link(path("edits.json"), path("hard.json"));
  render(render_words());
  fs::copy_file(path("out.exr"), path("sky.exr"));
  fs::copy_file(path("out.exr"), path("shots/000_first.exr"));
  fs::create_symlink("sky.exr", path("link.exr"));
  write("old.exr", kOld);
  fs::create_symlink("old.exr", path("new.exr"));
  const Words frame = {"render", path("scene.glb"), "--size", "8x8", "--spp", "1"};
  const auto refused = [&](const Words& more, const Words& parts) {
    expect_failure(frame + more, 2, parts + Words{"name another file"});
  };
  refused({"-o", path("a.exr"), "--report", path("sub/../scene.glb")}, {"--report", "the scene"});
  refused({"-o", path("link.exr"), "--env", path("here/sky.exr")}, {"-o", "--env"});
  refused({"-o", path("a.exr"), "--edits", path("edits.json"), "--report", path("hard.json")},
          {"--report", "hard.json", "--edits"});
  refused({"-o", path("a.exr"), "--report", path("here/here/a.exr")},
          {"--report", "it is also written by"});
  refused({"-o", path("new.exr"), "--heatmap", path("old.exr")},
          {"--heatmap", "it is also written by"});
  refused({"-o", path("a.exr"), "-o", path("A.exr")}, {"A.exr", "it is also written by"});
  fs::create_symlink("here/a.exr", path("dangling.json"));
  fs::create_symlink("dangling.json", path("sub/chain.json"));
  for (const char* name : {"dangling.json", "here/dangling.json"}) {
    refused({"-o", path("a.exr"), "--report", path(name)}, {"--report", "it is also written by"});
    refused({"-o", path("a.exr"), "--driver", "adaptive", "--tree", path(name)},
            {"--tree", "it is also written by"});
  }
  const Words shots = {"--driver", "bisection", "--snapshots", path("shots"), "-o"};
  refused(shots + Words{path("shots/003_0010pct.png")}, {"--snapshots", "it is also written by"});
  refused(shots + Words{path("b.exr"), "--report", path("shots/emberline-snapshots.json")},
          {"--snapshots", "it is also written by"});
  refused(shots + Words{path("b.exr"), "--reference", path("here/shots/000_first.exr")},
          {"--reference"});
  expect_failure({"compare", path("out.exr"), path("sky.exr"), "-o", path("link.exr")}, 2,
                 {"link.exr", "one of the pictures compared"});
  expect_failure({"heatmap", path("sky.exr"), "-o", path("here/link.exr")}, 2, {"picture itself"});
  expect_failure({"study", path("scene.glb"), "-o", path("here")}, 2, {"-o", "the scene"});
  // The files to which a scene refers are known only after the scene is read.
  GltfBuilder textured = lamp_scene();
  textured.push("images", {{"uri", "sub/b.png"}});
  textured.push("textures", {{"source", 0}});
  textured.root["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
  textured.write_gltf(path("t.gltf"), "t.bin");
  render(render_words({"-o", path("sub/b.png")}));
  fs::create_hard_link(path("sub/b.png"), path("c.png"));
  for (const Words& words :
       {Words{"-o", path("here/c.png")}, Words{"-o", path("c.exr"), "--report", path("t.bin")},
        Words{"-o", path("c.exr"), "--heatmap", path("sub/b.png")}}) {
    expect_failure(Words{"render", path("t.gltf"), "--size", "8x8", "--spp", "1"} + words, 2,
                   {words.back(), "the scene reads", "name another file"});
  }
  EXPECT_EQ(std::string(kOld).size(), read_bytes(path("old.exr")).size());
  write("table.cube", "LUT_1D_SIZE 2\n0 0 0\n1 1 1\n");
  write("config.ocio", R"(ocio_profile_version: 2
search_path: "."
roles: {default: lin, scene_linear: lin}
file_rules: [!<Rule> {name: Default, colorspace: default}]
displays: {sRGB: [!<View> {name: V, colorspace: out}]}
colorspaces:
  - !<ColorSpace> {name: lin}
  - !<ColorSpace> {name: out, from_reference: !<FileTransform> {src: table.cube}}
)");
  expect_failure(frame + Words{"-o", path("c.png"), "--report", path("here/table.cube")}, 2,
                 {"--report", "$OCIO config reads it"},
                 {.environment = {{"OCIO", path("config.ocio")}}});
  // Otherwise, files may have any names, and several outputs may share a device.
  render(frame + Words{"-o", path("a.exr"), "-o", path("sub/a.exr"), "--report", "/dev/null",
                       "--report", "/dev/null"});
  fs::remove(path("shots/000_first.exr"));
  render(frame + shots + Words{path("shots/final.exr"), "--snapshot-at", "first"});
}

// A shell or another program may append to the same log. If the command replaced the file, the
// contents would be lost.
TEST_F(OutputErrors, OpenStreamsAreWrittenNotReplaced) {
  write("log", "what was there\n");
  for (const char* name :
       {"/dev/stdout", "/dev/fd/1", "/proc/self/fd/1", "/proc/thread-self/fd/1"}) {
    const RunResult result =
        run(render_words({"--quiet", "--report", name}), {.stdout_path = path("log")});
    EXPECT_EQ(result.exit_code, 0) << result.describe();
  }
  const std::vector<uint8_t> bytes = read_bytes(path("log"));
  const std::string text(bytes.begin(), bytes.end());
  EXPECT_TRUE(text.starts_with("what was there\n{")) << text;
  EXPECT_EQ(std::count(text.begin(), text.end(), '{'), std::count(text.begin(), text.end(), '}'));
  std::filesystem::create_symlink("/dev/stdout", path("stream.png"));
  expect_failure(render_words({"-o", path("stream.png")}), 1,
                 {"stream.png", "an open file descriptor"});
  expect_failure(render_words({"--report", "/dev/fd/7"}), 1, {"/dev/fd/7"});
  const int of_another = ::open(path("log").c_str(), O_WRONLY | O_APPEND);
  const std::string name =
      "/proc/" + std::to_string(::getpid()) + "/fd/" + std::to_string(of_another);
  expect_failure(render_words({"--report", name}), 1, {name, "an open file descriptor"});
  ::close(of_another);
  EXPECT_EQ(read_bytes(path("log")), bytes);
  expect_failure(render_words({"--report", "/dev/stdin"}), 1, {"/dev/stdin"});
}

TEST_F(OutputErrors, ReportCannotBeFinished) {
  const RunResult result = run(render_words({"--quiet", "--report", "/dev/full"}));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("/dev/full"), std::string::npos) << result.err;
  ASSERT_EQ(result.error_lines().size(), 1u);
}

TEST_F(OutputErrors, UnwrittenResultsAreErrors) {
  const std::string file = scene();
  for (const Words& words : {Words{"info", file}, Words{"info", file, "--json"}, Words{"--version"},
                             Words{"render", file, "--size", "8x8", "--replay", "1,1,0"}}) {
    expect_failure(words, 1, {"standard output"}, {.stdout_path = "/dev/full"});
  }
}

// A daemon or "2>&-" closes standard streams. No output file may then get the descriptor of a
// standard stream.
TEST_F(OutputErrors, ClosedStreamsDoNotCorruptThePicture) {
  const Words words = render_words({"--threads", "1", "--verbose"});
  render(words);
  const std::vector<unsigned char> expected = read_bytes(path("out.exr"));
  for (const std::vector<int>& closed :
       {std::vector{0}, {1}, {2}, {0, 1}, {0, 2}, {1, 2}, {0, 1, 2}}) {
    SCOPED_TRACE(::testing::PrintToString(closed));
    std::filesystem::remove(path("out.exr"));
    const RunResult result = run(words, {.closed = closed});
    EXPECT_EQ(result.exit_code, 0) << result.describe();
    EXPECT_EQ(read_bytes(path("out.exr")), expected);
  }
  EXPECT_EQ(files(), (Words{"out.exr", "scene.glb"}));
  expect_failure({"info", scene()}, 1, {"standard output"}, {.closed = {1}});
}

// A name that the user or a scene provides must not start a new line or move the cursor.
TEST_F(OutputErrors, ControlCharactersInNamesAreEscaped) {
  expect_failure(
      {"render", path("a\nemberline: error: b\x1b[2J\r\xc2\x9b.glb"), "-o", path("out.exr")}, 3,
      {"a\\nemberline: error: b\\x1b[2J\\r\\xc2\\x9b.glb"});
  scene();
  const RunResult result = run(render_words({"-o", path("b\n\x1bK.png")}));
  EXPECT_EQ(result.exit_code, 0) << result.describe();
  EXPECT_NE(result.err.find("b\\n\\x1bK.png\n"), std::string::npos) << result.err;
  EXPECT_EQ(result.err.find('\x1b'), std::string::npos) << result.err;
}

}  // namespace
}  // namespace emberline::test
