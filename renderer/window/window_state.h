// State of the window that outlives it: its size, open panels, and how pictures are shown. Nothing
// of a scene.
#pragma once

#include <string>
#include <vector>

namespace emberline {

struct WindowState {
  int width = 1440, height = 860;  // of the window, screen coordinates
  bool maximized = false;
  bool panels = true;
  float panel_width = 27.0f;  // in heights of a line of text
  int panel_tab = 0;
  bool inspector = true;
  std::vector<std::string> recent_scenes;  // newest first, absolute paths

  static constexpr size_t kMostRecent = 8;
  void remember_scene(const std::string& path);
  bool operator==(const WindowState&) const = default;
};

// $XDG_CONFIG_HOME/emberline/view.json, or ~/.config/emberline/view.json; empty without a home.
std::string window_state_file();

// A file that is not there gives the defaults; one that cannot be used too, with a warning, and
// members out of range theirs.
WindowState read_window_state(const std::string& path);

// Makes the folder if need be. A disk that refuses costs a warning.
void write_window_state(const std::string& path, const WindowState& state);

// For files that the window writes without asking for a name: the first of "<stem><suffix>",
// "<stem>-2<suffix>", … that nothing has.
std::string free_file(const std::string& stem, const std::string& suffix);

}  // namespace emberline
