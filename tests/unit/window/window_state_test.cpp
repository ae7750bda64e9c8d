// Tests the window's saved state, and unusable state files.
#include "renderer/window/window_state.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "unit/output_folder.h"

namespace emberline {
namespace {

class WindowStateTest : public OutputFolder {
 protected:
  WindowState read(const std::string& text) {
    std::ofstream(path("view.json")) << text;
    return read_window_state(path("view.json"));
  }
};

// Users may link to settings that are stored elsewhere, so a link to a state file is followed.
TEST_F(WindowStateTest, NothingOfOthersIsWrittenOver) {
  std::ofstream(path("notes")) << "mine";
  std::filesystem::create_symlink("notes", path("link.json"));
  write_window_state(path("link.json"), {});
  EXPECT_EQ(std::filesystem::file_size(path("notes")), 4u);
  ASSERT_EQ(::mkfifo(path("pipe.json").c_str(), 0600), 0);
  write_window_state(path("pipe.json"), {});  // without waiting for a reader
  write_window_state(path("own.json"), {});
  std::filesystem::create_symlink("own.json", path("good.json"));
  WindowState wide;
  wide.width = 777;
  write_window_state(path("good.json"), wide);
  EXPECT_EQ(read_window_state(path("own.json")), wide);
}

TEST_F(WindowStateTest, ComesBackAsItWasWritten) {
  WindowState state;
  state.width = 1000;
  state.height = 700;
  state.maximized = true;
  state.panels = false;
  state.panel_width = 30.0f;
  state.panel_tab = 3;
  state.inspector = false;
  state.remember_scene("/a/b.glb");
  const std::string file = path("new/folder/view.json");
  write_window_state(file, state);
  EXPECT_EQ(read_window_state(file), state);
}

TEST_F(WindowStateTest, BrokenFilesGiveTheDefaults) {
  EXPECT_EQ(read_window_state(path("missing.json")), WindowState());
  EXPECT_EQ(read_window_state(path(".")), WindowState());
  for (const char* text : {"", "{", "[1, 2]", "3", "{\"width\": \"wide\", \"panels\": 3}",
                           "{\"width\": 1e300, \"height\": -4, \"panel_tab\": 77}",
                           "{\"recent_scenes\": {\"a\": 1}, \"panel_width\": null}"}) {
    EXPECT_EQ(read(text), WindowState()) << text;
  }
}

TEST_F(WindowStateTest, OneWrongMemberLeavesTheOthers) {
  const WindowState state = read("{\"width\": 5, \"height\": 900, \"inspector\": false}");
  EXPECT_EQ(state.width, WindowState().width);
  EXPECT_EQ(state.height, 900);
  EXPECT_FALSE(state.inspector);
}

TEST_F(WindowStateTest, InvalidUtf8NamesAreWritten) {
  WindowState state;
  state.recent_scenes = {"/a/\xff.glb"};
  write_window_state(path("view.json"), state);
  EXPECT_EQ(read_window_state(path("view.json")).recent_scenes.size(), 1u);
}

TEST_F(WindowStateTest, RecentScenesAreNewestFirstEachOnceAndFew) {
  WindowState state;
  for (int i = 0; i < 20; ++i) state.remember_scene("/s/" + std::to_string(i) + ".glb");
  state.remember_scene("/s/15.glb");
  EXPECT_EQ(state.recent_scenes.size(), WindowState::kMaxRecent);
  EXPECT_EQ(state.recent_scenes[0], "/s/15.glb");
  EXPECT_EQ(state.recent_scenes[1], "/s/19.glb");
}

TEST_F(WindowStateTest, LiesWhereTheDesktopSays) {
  setenv("XDG_CONFIG_HOME", "/x/y", 1);
  EXPECT_EQ(window_state_file(), "/x/y/emberline/view.json");
  setenv("XDG_CONFIG_HOME", "relative", 1);
  setenv("HOME", "/home/me", 1);
  EXPECT_EQ(window_state_file(), "/home/me/.config/emberline/view.json");
  unsetenv("XDG_CONFIG_HOME");
  unsetenv("HOME");
  EXPECT_EQ(window_state_file(), "");
}

}  // namespace
}  // namespace emberline
