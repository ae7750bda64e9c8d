#include "renderer/window/window_state.h"

#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>

#include "io/files/atomic_file.h"
#include "io/json/input.h"
#include "io/json/reader.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"

namespace emberline {
namespace {

using Json = nlohmann::ordered_json;
constexpr int kMinSide = 320, kMaxSide = 16384;
constexpr float kMinPanelWidth = 12.0f, kMaxPanelWidth = 60.0f;
constexpr int kMaxTab = 32;

template <typename T>
void read_number(const nlohmann::json& json, const char* name, T& value, T minimum, T maximum) {
  if (!json.contains(name) || !json[name].is_number()) return;
  const double number = json[name].template get<double>();
  if (number >= double(minimum) && number <= double(maximum)) value = T(number);
}

void read_flag(const nlohmann::json& json, const char* name, bool& value) {
  if (json.contains(name) && json[name].is_boolean()) value = json[name].get<bool>();
}

}  // namespace

void WindowState::remember_scene(const std::string& path) {
  const std::string absolute_path = std::filesystem::absolute(path).lexically_normal().string();
  std::erase(recent_scenes, absolute_path);
  recent_scenes.insert(recent_scenes.begin(), absolute_path);
  if (recent_scenes.size() > kMaxRecent) recent_scenes.resize(kMaxRecent);
}

std::string window_state_file() {
  const auto variable = [](const char* name) {
    const char* const value = std::getenv(name);
    return std::string(value ? value : "");
  };
  // Relative paths are ignored (XDG Base Directory Specification 0.8).
  std::filesystem::path folder = variable("XDG_CONFIG_HOME");
  if (!folder.is_absolute()) {
    if (variable("HOME").empty()) return {};
    folder = std::filesystem::path(variable("HOME")) / ".config";
  }
  return folder / "emberline" / "view.json";
}

WindowState read_window_state(const std::string& path) {
  WindowState state;
  std::error_code unknown;
  if (path.empty() || !std::filesystem::is_regular_file(path, unknown)) return state;
  nlohmann::json json;
  try {
    json = read_json(path);
    JsonReader(json, path).members();
  } catch (const InputError& error) {
    log_warning(std::string(error.what()) + "; the window opens with its default size and panels");
    return state;
  }
  read_number(json, "width", state.width, kMinSide, kMaxSide);
  read_number(json, "height", state.height, kMinSide, kMaxSide);
  read_flag(json, "maximized", state.maximized);
  read_flag(json, "panels", state.panels);
  read_number(json, "panel_width", state.panel_width, kMinPanelWidth, kMaxPanelWidth);
  read_number(json, "panel_tab", state.panel_tab, 0, kMaxTab);
  read_flag(json, "inspector", state.inspector);
  if (json.contains("recent_scenes") && json["recent_scenes"].is_array()) {
    for (const nlohmann::json& scene : json["recent_scenes"]) {
      if (scene.is_string()) state.recent_scenes.push_back(scene.get<std::string>());
    }
    if (state.recent_scenes.size() > WindowState::kMaxRecent) {
      state.recent_scenes.resize(WindowState::kMaxRecent);
    }
  }
  return state;
}

namespace {

// Returns whether the state file may be overwritten. The path may be a link to another file, which
// must not be replaced. So a link is followed only if its target looks like our own state file.
bool may_overwrite(const std::string& path) {
  std::error_code unknown;
  if (!std::filesystem::exists(path, unknown)) return true;
  if (!std::filesystem::is_regular_file(path, unknown)) return false;
  if (!std::filesystem::is_symlink(path, unknown)) return true;
  try {
    const nlohmann::json json = read_json(path);
    return json.contains("recent_scenes");
  } catch (const InputError&) {
    return false;
  }
}

}  // namespace

void write_window_state(const std::string& path, const WindowState& state) {
  if (path.empty()) return;
  if (!may_overwrite(path)) {
    log_warning("cannot save the window's size and panels: " + path +
                " is not a window settings file of Emberline; move it away");
    return;
  }
  const Json json = {{"width", state.width},
                     {"height", state.height},
                     {"maximized", state.maximized},
                     {"panels", state.panels},
                     {"panel_width", state.panel_width},
                     {"panel_tab", state.panel_tab},
                     {"inspector", state.inspector},
                     {"recent_scenes", state.recent_scenes}};
  std::error_code failed;
  std::filesystem::create_directories(std::filesystem::path(path).parent_path(), failed);
  try {
    constexpr auto kReplace = Json::error_handler_t::replace;  // names need not be UTF-8
    write_file_atomically(path, json.dump(2, ' ', false, kReplace) + "\n");
  } catch (const RenderError& error) {
    log_warning(std::string("cannot save the window's size and panels: ") + error.what());
  }
}

std::string unused_file_name(const std::string& stem, const std::string& suffix) {
  std::string name = stem + suffix;
  std::error_code unknown;  // ignored here: writing the file will report the error
  for (int i = 2; std::filesystem::exists(std::filesystem::symlink_status(name, unknown)); ++i) {
    name = stem + "-" + std::to_string(i) + suffix;
  }
  return name;
}

}  // namespace emberline
