// Tests AtomicFile: the target is replaced only by a complete file, and otherwise not touched. Also
// tests GrowingFile.
#include "io/files/atomic_file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <fstream>
#include <thread>
#include <vector>

#include "renderer/core/errors.h"
#include "unit/output_folder.h"

namespace emberline {
namespace {

namespace fs = std::filesystem;

using AtomicFileTest = OutputFolder;

TEST_F(AtomicFileTest, WritesWholeFiles) {
  write_file_atomically(path("r.json"), "{}");
  EXPECT_EQ(read_text(path("r.json")), "{}");
  write_file_atomically(path("r.json"), "");
  EXPECT_EQ(read_text(path("r.json")), "");
  EXPECT_EQ(contents(), std::vector<std::string>{"r.json"});
}

TEST_F(AtomicFileTest, KeepsLinksAndPermissions) {
  write_file_atomically(path("real"), "1");
  fs::permissions(path("real"), fs::perms::owner_read | fs::perms::owner_write);
  fs::create_symlink("real", path("link"));
  write_file_atomically(path("link"), "2");
  EXPECT_TRUE(fs::is_symlink(path("link")));
  EXPECT_EQ(read_text(path("real")), "2");
  EXPECT_EQ(fs::status(path("real")).permissions(), fs::perms::owner_read | fs::perms::owner_write);
}

TEST_F(AtomicFileTest, CreatesTheTargetOfALink) {
  fs::create_directory(path("scratch"));
  fs::create_symlink("scratch/out", path("link"));
  fs::create_symlink("link", path("chain"));
  write_file_atomically(path("chain"), "1");
  EXPECT_TRUE(fs::is_symlink(path("link")) && fs::is_symlink(path("chain")));
  EXPECT_EQ(read_text(path("scratch/out")), "1");
  fs::create_symlink("loop", path("loop"));
  EXPECT_THROW(write_file_atomically(path("loop"), "2"), RenderError);
  EXPECT_TRUE(fs::is_symlink(path("loop")));
}

TEST_F(AtomicFileTest, ToleratesLeftoversAndLongNames) {
  {
    std::ofstream(path("a.emberline.part-" + std::to_string(getpid())))
        << "left by a killed process";
  }
  write_file_atomically(path("a"), "x");
  EXPECT_EQ(read_text(path("a")), "x");
  const std::string name(255, 'n');
  write_file_atomically(path(name), "y");
  EXPECT_EQ(read_text(path(name)), "y");
}

// The next write of a target removes the files that a killed run has left for it. Files with
// similar names stay.
TEST_F(AtomicFileTest, StaleFilesOfTheTargetAreRemoved) {
  const auto leave = [this](const std::string& name) { std::ofstream(path(name)) << "left"; };
  for (const char* name :
       {"a.emberline.part-4711", "a.emberline.part-1", "a.emberline.part-4711-2"})
    leave(name);
  std::vector<std::string> others = {
      "b.emberline.part-1", "a.emberline.part-x", "a.emberline.part-007", "a.emberline.part-12-",
      "a.emberline.part-1a", "a.emberline.part-1.x", "xa.emberline.part-1", "a.emberline.part-",
      // Other programs, such as split(1), write these files.
      "a.part-1", "a.part-4711"};
  for (const std::string& name : others) leave(name);
  fs::create_directory(path("a.emberline.part-5"));
  fs::create_symlink("xa.emberline.part-1", path("a.emberline.part-6"));
  leave("a.emberline.part-7");
  fs::create_hard_link(path("a.emberline.part-7"), path("kept"));
  others.insert(others.end(),
                {"a", "a.emberline.part-5", "a.emberline.part-6", "a.emberline.part-7", "kept"});
  std::ranges::sort(others);
  write_file_atomically(path("a"), "x");
  EXPECT_EQ(contents(), others);
}

// The target folder is resolved at the start, because a frame takes hours and a link may change
// meanwhile.
TEST_F(AtomicFileTest, ALinkToTheFolderMayChangeMeanwhile) {
  fs::create_directory(path("one"));
  fs::create_directory(path("two"));
  fs::create_directory_symlink("one", path("now"));
  AtomicFile file(path("now/a"));
  file.write_at("x", 1, 0);
  fs::remove(path("now"));
  fs::create_directory_symlink("two", path("now"));
  file.commit();
  EXPECT_EQ(read_text(path("one/a")), "x");
  EXPECT_TRUE(fs::is_empty(path("two")));
}

TEST_F(AtomicFileTest, ANameThatIsTooLongIsKnownAtOnce) {
  EXPECT_THROW(AtomicFile(path(std::string(256, 'n'))), RenderError);
}

TEST_F(AtomicFileTest, AFileInUseStays) {
  AtomicFile first(path("a"));
  first.write_at("first", 5, 0);
  write_file_atomically(path("a"), "second");
  EXPECT_EQ(read_text(path("a")), "second");
  first.commit();
  EXPECT_EQ(read_text(path("a")), "first");
  EXPECT_EQ(contents(), std::vector<std::string>{"a"});
}

// Each writer looks for stale files while the others create, lock, rename and remove theirs.
TEST_F(AtomicFileTest, WritersOfOneTargetDoNotTakeEachOthersFiles) {
  std::atomic<int> failed{0};
  {
    std::vector<std::jthread> writers;
    for (int writer = 0; writer < 4; ++writer) {
      writers.emplace_back([&, writer] {
        for (int i = 0; i < 100; ++i) {
          try {
            AtomicFile file(path("a"));
            file.write_at("whole", 5, 0);
            if ((i + writer) % 3 != 0) file.commit();
          } catch (const RenderError&) {
            ++failed;
          }
        }
      });
    }
  }
  EXPECT_EQ(failed, 0);
  EXPECT_EQ(read_text(path("a")), "whole");
  EXPECT_EQ(contents(), std::vector<std::string>{"a"});
}

TEST_F(AtomicFileTest, DevicesAreWrittenDirectly) {
  write_file_atomically("/dev/null", "gone");
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
  expect_error<RenderError>([] { write_file_atomically("/dev/full", "x"); },
                            "No space left on device");
}

TEST_F(AtomicFileTest, GrowingFilesCanBeFollowed) {
  write_file_atomically(path("log"), "of before\n");
  GrowingFile log(path("log"));
  EXPECT_EQ(read_text(path("log")), "");
  log.append("one\n");
  log.append("two\n");
  EXPECT_EQ(read_text(path("log")), "one\ntwo\n");
  GrowingFile full("/dev/full");
  expect_error<RenderError>([&] { full.append("x"); }, "No space left on device");
  expect_error<RenderError>([&] { GrowingFile folder(path("")); }, "Is a directory");
}

TEST_F(AtomicFileTest, GrowingFilesWaitForNoReader) {
  ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
  expect_error<RenderError>([&] { GrowingFile unread(path("pipe")); }, "without a reader");
  const int reader = ::open(path("pipe").c_str(), O_RDONLY | O_NONBLOCK);
  GrowingFile log(path("pipe"));
  log.append("one\n");
  char read[4];
  EXPECT_EQ(::read(reader, read, sizeof read), 4);
  const std::string more(size_t(1) << 22, 'x');  // more than any pipe can buffer
  expect_error<RenderError>([&] { log.append(more); }, "reads the pipe is too slow");
  ::close(reader);
}

}  // namespace
}  // namespace emberline
