// The settings of a frame by name, one row each, for command lines, files of settings, pictures'
// headers and study records.
#pragma once

#include <cstdint>
#include <functional>
#include <initializer_list>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/json/reader.h"
#include "renderer/engine/frame_settings.h"

namespace emberline {

enum class SettingGroup : uint8_t {
  kLoading,   // how the scene's files are read
  kEdits,     // what is changed of it
  kLight,     // environment, which sides of surfaces are seen
  kView,      // camera, crop
  kSample,    // what a sample is
  kSeed,      // which of its kind
  kSchedule,  // the order of the work
  kCounts,    // how many samples each pixel gets
  kChannels,  // what is kept of them
  kPart,      // which of them, to be merged with the others
  kTurn,      // which of several frames
};

struct SettingChoice {
  std::string name, summary;
};

struct Setting {
  std::string name;  // of its option, without the dashes
  SettingGroup group;
  std::string type;  // of its value, for --help; empty: on or off
  std::string help;  // a line; in brackets what holds where nothing is given
  // Throws UsageError: the option, the text, what is valid.
  std::function<void(FrameSettings& settings, std::string_view text)> read;
  // A text of which read() makes the same value; empty: none is given.
  std::function<std::string(const FrameSettings& settings)> text;
  std::vector<SettingChoice> choices = {};  // the valid names, if its value is one of a table
  bool file = false;                        // its value is a path
};

std::span<const Setting> setting_table();
// Null for an unknown name.
const Setting* find_setting(std::string_view name);

// Names and texts of the settings that have a text, in the table's order: of all, or of these
// groups.
using SettingTexts = std::vector<std::pair<std::string, std::string>>;
SettingTexts setting_texts(const FrameSettings& settings,
                           std::initializer_list<SettingGroup> groups = {}, bool files = true);

// A value of a document, of which `reader` says where it stands, as the text that an option would
// have. Throws InputError.
std::string text_of_json(const nlohmann::json& value, const JsonReader& reader);

// A file of settings: one JSON object, the names above with texts, numbers, true or false. It says
// how a frame is rendered, and not of which scene. A relative path in it is relative to the file.
// Settings that it does not name stay as they are. Throws InputError with the place.
void read_settings(const std::string& path, FrameSettings& settings);
// Writes all settings that differ from the defaults, as read_settings() reads them.
std::string settings_json(const FrameSettings& settings, const std::string& path);

}  // namespace emberline
