// Persistent state of the window: size, panels and recent scenes, but no settings of a scene.
#pragma once

#include <string>
#include <vector>

namespace emberline {

struct WindowState {
  int width = 1440, height = 860;  // of the window, in screen coordinates
  bool maximized = false;
  bool panels = true;
  float panel_width = 27.0f;  // in line heights
  int panel_tab = 0;
  bool inspector = true;
  std::vector<std::string> recent_scenes;  // newest first, absolute paths

  static constexpr size_t kMaxRecent = 8;
  void remember_scene(const std::string& path);
  bool operator==(const WindowState&) const = default;
};

// $XDG_CONFIG_HOME/emberline/view.json, or ~/.config/emberline/view.json; empty without a home.
std::string window_state_file();

// Returns the defaults if the file is missing or, with a warning, unusable. Members out of range
// keep their defaults.
WindowState read_window_state(const std::string& path);

// Creates the folder if needed. Failure to write is only a warning.
void write_window_state(const std::string& path, const WindowState& state);

// Name for a file that the window writes without asking: the first unused one of "<stem><suffix>",
// "<stem>-2<suffix>" and so on.
std::string unused_file_name(const std::string& stem, const std::string& suffix);

}  // namespace emberline
