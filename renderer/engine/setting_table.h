// The settings of a frame by name, one row each, for command lines, settings files, picture headers
// and study records.
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
  kEdits,     // changes to the scene
  kLight,     // environment, backfaces
  kView,      // camera, crop
  kSample,    // definition of a sample
  kSeed,      // noise realisation
  kSchedule,  // order of the work
  kCounts,    // number of samples per pixel
  kChannels,  // recorded channels
  kPart,      // part of a frame, for merging
  kTurn,      // frame of a turntable
};

struct SettingChoice {
  std::string name, summary;
};

struct Setting {
  std::string name;  // option name without dashes
  SettingGroup group;
  std::string type;  // value type for --help; empty: a flag
  std::string help;  // one line; the default is in brackets
  // Throws UsageError with the option, the text and the valid values.
  std::function<void(FrameSettings& settings, std::string_view text)> read;
  // The text from which read() makes the same value; empty: not given.
  std::function<std::string(const FrameSettings& settings)> text;
  std::vector<SettingChoice> choices = {};  // valid names, if the value comes from a table
  bool file = false;                        // the value is a path
};

std::span<const Setting> setting_table();
// Null for an unknown name.
const Setting* find_setting(std::string_view name);

// Names and texts of the given settings in table order, optionally of some groups only.
using SettingTexts = std::vector<std::pair<std::string, std::string>>;
SettingTexts setting_texts(const FrameSettings& settings,
                           std::initializer_list<SettingGroup> groups = {}, bool files = true);

// Converts a JSON value to the text that an option would have; `reader` gives its place. Throws
// InputError.
std::string text_of_json(const nlohmann::json& value, const JsonReader& reader);

// Reads a settings file: a JSON object with the names above and texts, numbers, true or false. It
// describes how a frame is rendered, not which scene. Relative paths are relative to the file;
// unnamed settings are unchanged. Throws InputError with the place.
void read_settings(const std::string& path, FrameSettings& settings);
// Returns all settings that differ from the defaults, in the format of read_settings().
std::string settings_json(const FrameSettings& settings, const std::string& path);

}  // namespace emberline
