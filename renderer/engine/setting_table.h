// A table with a row for each setting of a frame. Command lines, settings files, picture headers
// and study records use it.
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
  kSeed,      // pattern of the noise
  kSchedule,  // order of the work
  kCounts,    // number of samples per pixel
  kChannels,  // recorded channels
  kPart,      // part of a frame, for merging
  kTurn,      // frame of a turntable
};

// Sections of help texts, in the order in which they are shown.
enum class HelpSection : uint8_t {
  kOutput,
  kSamples,
  kView,
  kLight,
  kScene,
  kLimits,
  kParts,
  kInspection,
  // Sections of options that are not frame settings.
  kWindow,
  kSession,
  kJobs,
  kStudy,
  kGeneral,
};
std::string_view title_of(HelpSection section);

// The help of one option. For a frame setting, it is in the row of the setting table.
struct OptionText {
  HelpSection section;
  // One line for --help, at most 70 characters. Empty: only --help-all lists the option.
  std::string brief = {};
  std::string full = {};      // sentences for --help-all, man pages and the options page
  std::string fallback = {};  // the default in words, if the default value has no text
  std::string example = {};   // options as typed
};

struct SettingChoice {
  std::string name, summary;
};

struct Setting {
  std::string name;  // option name without dashes
  SettingGroup group;
  std::string type;  // value type for --help; empty: a flag
  OptionText help;
  // Throws a UsageError that names the option, the text and the valid values.
  std::function<void(FrameSettings& settings, std::string_view text)> read;
  // Returns the value as a text that read() accepts; empty if the setting is not given.
  std::function<std::string(const FrameSettings& settings)> text;
  std::vector<SettingChoice> choices = {};  // valid names, if the value comes from a table
  bool file = false;                        // the value is a path
};

std::span<const Setting> setting_table();
// Returns the text of the setting's value, or else the default in words; empty if there is none.
std::string default_of(const Setting& setting, const FrameSettings& settings);
// Returns null for an unknown name.
const Setting* find_setting(std::string_view name);

// Returns the names and texts of all given settings in table order. If `groups` is not empty,
// returns only the settings of these groups. If `files` is false, omits settings that are paths.
using SettingTexts = std::vector<std::pair<std::string, std::string>>;
SettingTexts setting_texts(const FrameSettings& settings,
                           std::initializer_list<SettingGroup> groups = {}, bool files = true);

// Converts a JSON value to the text that a user would give to an option. Throws an InputError that
// names the place in the file, which `reader` knows.
std::string text_of_json(const nlohmann::json& value, const JsonReader& reader);

// Reads a settings file: a JSON object whose keys are names of settings and whose values are texts,
// numbers, true or false. The file says how to render a frame, but not which scene. Relative paths
// in the file are relative to the file's folder. Settings that the file does not name are
// unchanged. Throws an InputError that names the place in the file.
void read_settings(const std::string& path, FrameSettings& settings);
// Returns all settings that differ from the defaults, in the format of read_settings(). Paths are
// relative to the folder of `path`.
std::string settings_json(const FrameSettings& settings, const std::string& path);

}  // namespace emberline
