// Tests which files a checkpoint may replace, and what happens to checkpoints while a frame
// renders.
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>

#include "cli/command_test.h"
#include "io/files/record_file.h"

namespace emberline::test {
namespace {

namespace fs = std::filesystem;

class CheckpointFile : public CommandTest {
 protected:
  static constexpr const char* kNotes = "EMBRACE the user's notes\n";

  void expect_notes(const std::string& name) const {
    const std::vector<uint8_t> bytes = read_bytes(path(name));
    EXPECT_EQ(std::string(bytes.begin(), bytes.end()), kNotes) << name;
  }
  // Returns whether the checkpoint has a record. A record is appended as a whole, so it can be read
  // as soon as it exists.
  static bool has_record(const std::string& file) {
    std::error_code none;
    return fs::exists(file, none) && !RecordFile(file).records().empty();
  }
};

TEST_F(CheckpointFile, ReplacesNoForeignFile) {
  write("notes.txt", kNotes);
  write("empty", "");
  for (const char* driver : {"bucket", "adaptive"}) {
    for (const char* name : {"notes.txt", "empty"}) {
      const Words words = render_words({"--driver", driver, "--checkpoint", path(name)});
      expect_failure(words, 2,
                     {"--checkpoint", name, "not an Emberline checkpoint", "name another file"});
      expect_failure(words + Words{"--resume"}, 3, {name, "not an Emberline checkpoint"});
    }
  }
  expect_notes("notes.txt");
  // The command must find this error before it loads the scene.
  expect_failure(
      {"render", path("no scene.glb"), "-o", path("out.exr"), "--checkpoint", path("notes.txt")}, 2,
      {"notes.txt", "not an Emberline checkpoint"});
}

// If no option names the checkpoint, it has a default name beside the output. That name is checked
// in the same way.
TEST_F(CheckpointFile, ReplacesNoForeignFileNextToTheOutput) {
  const Words frame = {"render", scene(), "-o", path("out.exr"), "--size", "16x16"};
  const std::pair<std::string, Words> rows[] = {
      {"out.exr.checkpoint", {"--resumable"}},
      {"out.exr.part-1-of-2.checkpoint", {"--part", "1/2", "--bucket-size", "8"}},
      {"out.exr.samples-0-2.checkpoint", {"--sample-range", "0-2"}}};
  for (const auto& [name, words] : rows) {
    write(name, kNotes);
    expect_failure(frame + words, 2, {name, "not an Emberline checkpoint"});
    expect_failure(frame + words + Words{"--resume"}, 3, {name, "not an Emberline checkpoint"});
    expect_notes(name);
  }
}

TEST_F(CheckpointFile, DoesNotWriteThroughLinksToForeignFiles) {
  fs::create_directory(path("elsewhere"));
  write("elsewhere/notes.txt", kNotes);
  for (const char* target : {"elsewhere/notes.txt", "elsewhere/nothing"}) {
    fs::create_symlink(target, path("out.exr.checkpoint"));
    expect_failure(render_words({"--resumable"}), 2, {"out.exr.checkpoint"});
    const RunResult resumed = run(render_words({"--resume"}));
    EXPECT_EQ(resumed.exit_code, 3) << resumed.describe();
    EXPECT_TRUE(fs::is_symlink(path("out.exr.checkpoint")));
    EXPECT_FALSE(fs::exists(path("elsewhere/nothing")));
    fs::remove(path("out.exr.checkpoint"));
  }
  expect_notes("elsewhere/notes.txt");
  fs::create_hard_link(path("elsewhere/notes.txt"), path("out.exr.checkpoint"));
  expect_failure(render_words({"--resumable"}), 2,
                 {"out.exr.checkpoint", "not an Emberline checkpoint"});
  expect_notes("elsewhere/notes.txt");
}

TEST_F(CheckpointFile, ReplacesNoCheckpointOfAnotherFrame) {
  render(render_words({"--resumable", "--spp", "8"}));
  const std::string kept = path("out.exr.checkpoint");
  fs::rename(kept, path("kept"));
  fs::create_symlink("kept", path("symbolic"));
  const std::vector<uint8_t> before = read_bytes(path("kept"));
  for (const char* name : {"kept", "symbolic"}) {
    expect_failure(render_words({"-q", "--spp", "9", "--checkpoint", path(name)}), 2,
                   {"--checkpoint", name, "another frame", "--spp", "name another file"});
  }
  fs::create_hard_link(path("kept"), kept);
  expect_failure(render_words({"--resumable", "--spp", "9"}), 2, {"another frame"});
  EXPECT_EQ(read_bytes(path("kept")), before);
  fs::remove(kept);
  fs::copy_file(path("kept"), kept);
  render(render_words({"--resumable", "--spp", "9"}));  // may replace the checkpoint of its output
  EXPECT_NE(read_bytes(kept), before);
}

// The checkpoint may be a link, for example to another disk.
TEST_F(CheckpointFile, ResumesThroughALink) {
  // A checkpoint lists buckets in the order in which they are finished. With one thread, this order
  // is always the same.
  const Words part = {"--part", "1/2", "--bucket-size", "8", "--threads", "1"};
  const Words words = render_words(part + Words{"--resume"});
  render(words);
  fs::create_directory(path("big"));
  const std::string name = path("out.exr.part-1-of-2.checkpoint");
  fs::rename(name, path("big/part"));
  fs::create_symlink("big/part", name);
  const std::vector<uint8_t> before = read_bytes(path("big/part"));
  render(words);
  EXPECT_EQ(read_bytes(path("big/part")), before);
  // Without --resume, the frame begins its checkpoint again.
  render(render_words(part));
  EXPECT_TRUE(fs::is_symlink(name));
  EXPECT_EQ(read_bytes(path("big/part")), before);
}

// A merged frame can be extended like a frame that was rendered as a whole. Tests parts of buckets,
// with and without a threshold, and parts of samples.
TEST_F(CheckpointFile, AMergedFrameCanBeExtended) {
  const Words frame = {"render",         scene(),         "-o", path("out.exr"), "--size",
                       "16x16",          "--bucket-size", "8",  "--aov",         "stop",
                       "--bucket-order", "spiral"};
  const std::string merged = path("merged.exr"), kept = path("merged.exr.checkpoint");
  const auto merge = [&](const std::string& a, const std::string& b) {
    render({"merge", path("out.exr." + a), path("out.exr." + b), "-o", merged, "--resumable"});
  };
  for (const Words& limits : {Words{}, Words{"--noise-threshold", "0.01"}}) {
    SCOPED_TRACE(limits.size());
    const Words whole = frame + limits + Words{"--spp", "16"};
    for (const char* part : {"1/2", "2/2"}) render(whole + Words{"--part", part});
    merge("part-1-of-2.checkpoint", "part-2-of-2.checkpoint");
    // The merged checkpoint contains the whole frame.
    const RunResult resumed =
        render(whole + Words{"--checkpoint", kept, "--resumable", "--resume"});
    EXPECT_NE(resumed.err.find("rendered 0 samples"), std::string::npos) << resumed.err;
    render({"extend", merged, "--spp", "40"});
    render(whole + Words{"--resumable"});
    render({"extend", path("out.exr"), "--spp", "40"});
    EXPECT_EQ(first_difference(read_exr(path("out.exr")), read_exr(merged)), "");
  }
  for (const char* range : {"0-8", "8-16"}) render(frame + Words{"--sample-range", range});
  merge("samples-0-8.checkpoint", "samples-8-16.checkpoint");
  render({"extend", merged, "--spp", "40"});
  render(frame + Words{"--spp", "40"});
  const ExrPicture expected = read_exr(path("out.exr")), extended = read_exr(merged);
  for (const auto& [name, values] : expected.channels) {
    for (size_t i = 0; i < values.size(); ++i) {
      // The samples of each range are summed separately, so the sums are rounded differently.
      ASSERT_NEAR(extended.channels.at(name)[i], values[i], 2e-6f * std::abs(values[i])) << name;
    }
  }
}

TEST_F(CheckpointFile, AMergedFrameThatCannotBeExtendedIsRefused) {
  const auto refuse = [&](const Words& parts, const std::string& why) {
    expect_failure(Words{"merge", "-o", path("all.exr"), "--resumable"} + parts, 3,
                   {"--resumable: ", why});
    EXPECT_FALSE(fs::exists(path("all.exr")));
  };
  const auto keep = [&](const std::string& name, const Words& more) {
    render(render_words(Words{"--bucket-size", "8", "--resumable", "--checkpoint", path(name)} +
                        more));
  };
  keep("a", {});
  keep("b", {"--seed", "1"});
  refuse({path("a"), path("b")}, "an average over seeds");
  keep("c", {"--driver", "bisection"});
  refuse({path("c")}, "only with --driver bucket");
  keep("d", {"--part", "1/2"});
  refuse({path("d"), "--allow-holes", "-q"}, "a frame with holes");
  keep("e", {"--sampler", "stratified"});
  expect_failure({"merge", path("e"), "-o", path("all.exr"), "--resumable"}, 3,
                 {"stratified", "needs the number of samples in advance"});
  expect_failure({"merge", path("a"), "-o", path("a.exr"), "--checkpoint", "x"}, 2,
                 {"--checkpoint"});
}

// If there is no checkpoint, the error tells the user how to keep one.
TEST_F(CheckpointFile, ExtendingWithoutACheckpointNamesTheCommandThatKeepsOne) {
  const Words words = render_words({"--seed", "3"});
  render(words);
  expect_failure({"extend", path("out.exr"), "--spp", "8"}, 3,
                 {"out.exr.checkpoint", "emberline render", "--seed 3 --resumable"});
  expect_failure({"extend", path("out.png"), "--spp", "8"}, 3, {"out.png: file not found"});
  render(render_words({"-o", path("out.png")}));
  expect_failure({"extend", path("out.png"), "--spp", "8"}, 3,
                 {"out.png.checkpoint", "emberline render", "--resumable"});
  render(render_words({"--part", "1/2"}));
  expect_failure(
      {"extend", path("out.exr.part-1-of-2.checkpoint"), "--spp", "8", "-o", path("a.exr")}, 3,
      {"emberline merge and --resumable"});
}

// As a render does, a merge replaces the checkpoint of its output, whatever settings that has. If
// the name is a link, the checkpoint behind it must belong to the same frame.
TEST_F(CheckpointFile, AMergeReplacesOnlyTheCheckpointOfItsOutput) {
  const auto keep = [&](const std::string& name, const std::string& seed) {
    render(render_words(
        {"--bucket-size", "8", "--checkpoint", path(name), "--resumable", "--seed", seed}));
    return read_bytes(path(name));
  };
  keep("whole", "1");
  const std::vector<uint8_t> other = keep("other", "2");
  const Words merge = {"merge", path("whole"), "-o", path("all.exr"), "--resumable"};
  fs::create_symlink("other", path("all.exr.checkpoint"));
  expect_failure(merge, 2, {"all.exr.checkpoint", "another frame: --seed"});
  EXPECT_EQ(read_bytes(path("other")), other);
  fs::remove(path("all.exr.checkpoint"));
  fs::copy_file(path("other"), path("all.exr.checkpoint"));
  EXPECT_NE(render(merge).err.find("all.exr.checkpoint is replaced"), std::string::npos);
  render({"extend", path("all.exr"), "--spp", "2"});
  write("all.exr.checkpoint", kNotes);
  expect_failure(merge, 2, {"all.exr.checkpoint", "not an Emberline checkpoint"});
}

TEST_F(CheckpointFile, SettingsThatAreNoObjectAreRefused) {
  for (const char* head : {R"({"settings": []})", R"({"schedule": "8"})"}) {
    write("bad", pack_file_head(head));
    expect_failure({"merge", path("bad"), "-o", path("all.exr"), "--resumable"}, 3,
                   {"bad", "not an object"});
    expect_failure({"extend", path("bad"), "-o", path("all.exr"), "--spp", "2"}, 3,
                   {"bad", "not an object"});
  }
}

TEST_F(CheckpointFile, ExtendingReplacesOnlyTheCheckpoint) {
  render(render_words({"--resumable", "--spp", "64"}));
  const Words extend = {"extend", path("out.exr"), "--spp", "128"};
  expect_failure(extend + Words{"--report", path("out.exr.checkpoint")}, 2,
                 {"--report", "the frame to extend"});
  write("out.exr.checkpoint.next", kNotes);
  expect_failure(extend, 3, {"out.exr.checkpoint.next", "not an Emberline checkpoint"});
  expect_notes("out.exr.checkpoint.next");
  fs::remove(path("out.exr.checkpoint.next"));
  write("notes.txt", kNotes);
  fs::create_symlink("notes.txt", path("out.exr.checkpoint.next"));
  expect_failure(extend, 3, {"out.exr.checkpoint.next", "not an Emberline checkpoint"});
  expect_notes("notes.txt");
  fs::remove(path("out.exr.checkpoint.next"));
  render(extend);
  EXPECT_FALSE(fs::exists(path("out.exr.checkpoint.next")));
}

// The result of a part is its checkpoint. If another program removes the checkpoint, the part has
// failed.
TEST_F(CheckpointFile, PartWithALostFileFails) {
  const std::string file = path("out.exr.part-1-of-2.checkpoint");
  const std::pair<const char*, std::function<void()>> losses[] = {
      {"removed", [&] { fs::remove(file); }},
      {"replaced",
       [&] {
         write("notes.txt", kNotes);
         fs::rename(path("notes.txt"), file);
       }},
      {"cut", [&] { fs::resize_file(file, 0); }},
      // The header of the cut record is still valid. Records that are appended later leave a hole
      // in it.
      {"cut within a record", [&] { fs::resize_file(file, fs::file_size(file) - 100); }},
      {"overwritten", [&] {
         std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
         stream.seekp(-100, std::ios::end).write(std::string(64, 'x').data(), 64);
       }}};
  for (const auto& [what, lose] : losses) {
    // The message is the same for each loss, so it is enough to test one loss without --quiet.
    const bool twice = what == std::string("removed");
    for (const bool quiet : twice ? std::vector{true, false} : std::vector{true}) {
      SCOPED_TRACE(what);
      fs::remove(file);
      const Words words = {
          "render", scene(),         "-o", path("out.exr"), "--size", "64x64",     "--spp",
          "500",    "--bucket-size", "16", "--part",        "1/2",    "--threads", "1"};
      Process process(words + (quiet ? Words{"--quiet"} : Words{}), {.folder = folder_.path()});
      for (int i = 0; i < 60000 && !has_record(file); ++i) ::usleep(1000);
      ASSERT_TRUE(has_record(file)) << process.error_so_far();
      process.send(SIGSTOP);  // so that the frame cannot finish before the loss
      lose();
      process.send(SIGCONT);
      const RunResult result = process.wait();
      EXPECT_EQ(result.exit_code, 1) << result.describe();
      const Words lines = result.error_lines();
      ASSERT_FALSE(lines.empty());
      if (quiet) {
        EXPECT_EQ(lines.size(), 1u) << result.describe();
      }
      EXPECT_EQ(std::ranges::count_if(
                    lines, [](const auto& line) { return line.starts_with("emberline: error: "); }),
                1)
          << result.describe();
      EXPECT_NE(result.err.find(file + ":"), std::string::npos) << result.describe();
      EXPECT_EQ(result.err.find("has this part"), std::string::npos) << result.describe();
    }
  }
}

// --quiet must not suppress errors.
TEST_F(CheckpointFile, FullDiskIsReportedWithQuiet) {
  const Words part = {"render", scene(), "-o",     path("out.exr"), "--size", "64x64",
                      "--spp",  "2",     "--part", "1/2",           "-q"};
  const RunResult result = run(part, {.folder = folder_.path(), .file_size_limit = 8192});
  EXPECT_EQ(result.exit_code, 1) << result.describe();
  EXPECT_EQ(result.error_lines().size(), 1u) << result.describe();
  EXPECT_NE(result.err.find("emberline: error: "), std::string::npos) << result.describe();
  EXPECT_NE(result.err.find("out.exr.part-1-of-2.checkpoint"), std::string::npos) << result.err;
}

}  // namespace
}  // namespace emberline::test
