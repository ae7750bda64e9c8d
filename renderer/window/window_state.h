// Persistent state of the window: size, panels and recent scenes, but no settings of a scene.
#pragma once

#include <string>
#include <vector>

namespace emberline {

struct WindowState {
  int width = 1440, height = 860;  // window size in screen coordinates, at interface scale 1
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

// Returns $XDG_CONFIG_HOME/emberline/view.json, or else ~/.config/emberline/view.json. The result
// is empty if neither XDG_CONFIG_HOME nor HOME is set.
std::string window_state_file();

// Returns the defaults if the file is missing or unusable; warns if it is unusable. Members out of
// range keep their defaults.
WindowState read_window_state(const std::string& path);

// Creates the folder if needed. Only warns if writing fails.
void write_window_state(const std::string& path, const WindowState& state);

// Chooses the name of a file that the window writes without asking the user: the first of
// "<stem><suffix>", "<stem>-2<suffix>" and so on that does not exist.
std::string unused_file_name(const std::string& stem, const std::string& suffix);

}  // namespace emberline
