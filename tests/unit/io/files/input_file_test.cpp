// Tests opening input files: anything but a regular file is rejected at once.
#include "io/files/input_file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "renderer/core/errors.h"
#include "support/temp_folder.h"

namespace emberline {
namespace {

using test::TempFolder;
using test::write_text;

std::string message_of(const std::string& path, const std::string& place) {
  try {
    InputFile(path, place);
  } catch (const InputError& error) {
    return error.what();
  }
  return "opened";
}

TEST(InputFile, ReadsAllAndRanges) {
  const TempFolder folder;
  write_text(folder / "a", "0123456789");
  const InputFile file(folder / "a");
  EXPECT_EQ(file.size(), 10u);
  EXPECT_EQ(file.read_text(), "0123456789");
  EXPECT_EQ(file.read_all().size(), 10u);
  char part[3];
  file.read(4, 3, part);
  EXPECT_EQ(std::string(part, 3), "456");
  EXPECT_EQ(file.try_read(8, 3, part), 2);
  EXPECT_EQ(file.try_read(99, 3, part), 0);
}

// Reading a pipe would wait for a writer, and reading /dev/zero would never end.
TEST(InputFile, RefusesNonRegularFiles) {
  const TempFolder folder;
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  EXPECT_NE(message_of(folder / "pipe", "a#/b").find("a#/b: is a pipe"), std::string::npos);
  EXPECT_NE(message_of("/dev/zero", "/dev/zero").find("/dev/zero: is a device"), std::string::npos);
  EXPECT_NE(message_of(folder.path(), "x").find("x: is a directory"), std::string::npos);
  EXPECT_NE(message_of(folder / "none", "x").find("x: file not found: "), std::string::npos);
  ASSERT_EQ(::symlink((folder / "loop").c_str(), (folder / "loop").c_str()), 0);
  EXPECT_NE(message_of(folder / "loop", "x").find("x: cannot access the file"), std::string::npos);
  EXPECT_FALSE(InputFile::try_open(folder / "none"));
}

TEST(InputFile, NoticesThatTheFileBecameShorter) {
  const TempFolder folder;
  write_text(folder / "a", "0123456789");
  const InputFile file(folder / "a");
  ASSERT_EQ(::truncate((folder / "a").c_str(), 4), 0);
  EXPECT_THROW(file.read_all(), InputError);
}

TEST(InputFile, IdentityBelongsToTheFileNotItsName) {
  const TempFolder folder;
  write_text(folder / "a", "a");
  write_text(folder / "b", "a");
  ASSERT_EQ(::link((folder / "a").c_str(), (folder / "hard").c_str()), 0);
  ASSERT_EQ(::symlink("a", (folder / "soft").c_str()), 0);
  const FileIdentity a = InputFile(folder / "a").named_file("a").identity;
  EXPECT_EQ(file_identity(folder / "hard"), a);
  EXPECT_EQ(file_identity(folder / "soft"), a);
  EXPECT_NE(file_identity(folder / "b"), a);
  EXPECT_FALSE(file_identity(folder / "none"));
}

TEST(InputFile, StateIsFromTheTimeOfOpening) {
  const TempFolder folder;
  write_text(folder / "a", "a");
  const NamedFile then = InputFile(folder / "a").named_file("it");
  EXPECT_EQ(then.name, "it");
  EXPECT_EQ(then.path, folder / "a");
  ASSERT_TRUE(stat_file(folder / "a"));
  EXPECT_EQ(stat_file(folder / "a")->state, then.state);
  EXPECT_EQ(stat_file(folder / "a")->identity, then.identity);
  const timespec other[2] = {{1, 2}, {3, 4}};
  ASSERT_EQ(::utimensat(AT_FDCWD, (folder / "a").c_str(), other, 0), 0);
  EXPECT_EQ(stat_file(folder / "a")->state, (FileState{1, 3'000'000'004}));
  EXPECT_NE(stat_file(folder / "a")->state, then.state);
  EXPECT_FALSE(stat_file(folder / "none"));
}

TEST(InputFile, KernelTextsHaveNoSize) {
  EXPECT_NE(read_kernel_text("/proc/self/status").find("VmHWM:"), std::string::npos);
  EXPECT_EQ(read_kernel_text("/proc/self/none"), "");
}

}  // namespace
}  // namespace emberline
