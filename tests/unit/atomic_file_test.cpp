// Files that appear whole or not at all.
#include "io/atomic_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "renderer/core/errors.h"
#include "unit/output_folder.h"

namespace emberline {
namespace {

namespace fs = std::filesystem;

using AtomicFileTest = OutputFolder;

TEST_F(AtomicFileTest, WritesWholeFiles) {
  write_file_atomically(path("r.json"), "{}");
  EXPECT_EQ(slurp(path("r.json")), "{}");
  write_file_atomically(path("r.json"), "");
  EXPECT_EQ(slurp(path("r.json")), "");
  EXPECT_EQ(contents(), std::vector<std::string>{"r.json"});
}

TEST_F(AtomicFileTest, KeepsLinksAndPermissions) {
  write_file_atomically(path("real"), "1");
  fs::permissions(path("real"), fs::perms::owner_read | fs::perms::owner_write);
  fs::create_symlink("real", path("link"));
  write_file_atomically(path("link"), "2");
  EXPECT_TRUE(fs::is_symlink(path("link")));
  EXPECT_EQ(slurp(path("real")), "2");
  EXPECT_EQ(fs::status(path("real")).permissions(), fs::perms::owner_read | fs::perms::owner_write);
}

TEST_F(AtomicFileTest, LeftoversAndLongNamesAreNoObstacle) {
  { std::ofstream(path("a.part-" + std::to_string(getpid()))) << "left by a killed process"; }
  write_file_atomically(path("a"), "x");
  EXPECT_EQ(slurp(path("a")), "x");
  const std::string name(255, 'n');
  write_file_atomically(path(name), "y");
  EXPECT_EQ(slurp(path(name)), "y");
}

TEST_F(AtomicFileTest, DevicesAreWrittenDirectly) {
  write_file_atomically("/dev/null", "gone");
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
  expect_error<RenderError>([] { write_file_atomically("/dev/full", "x"); },
                            "No space left on device");
}

}  // namespace
}  // namespace emberline
