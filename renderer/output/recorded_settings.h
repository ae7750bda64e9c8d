// Reads back the settings that the header of an EXR records (settings_attributes() in report.h).
#pragma once

#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "renderer/core/errors.h"
#include "renderer/engine/frame_settings.h"

namespace emberline {

struct Setting;

// Returns make(). Turns a UsageError into an InputError for the file, because the invalid settings
// come from the file and not from the user's options.
template <typename Make>
auto convert_usage_errors(const std::string& path, const Make& make) {
  try {
    return make();
  } catch (const UsageError& error) {
    throw InputError(path, "its settings are invalid: {}", error.what());
  }
}

class RecordedSettings {
 public:
  // Reads the header's attributes. Ignores attributes whose names do not begin with "emberline:".
  // Also ignores the blanks that pad a text (outputs.h).
  explicit RecordedSettings(std::span<const std::pair<std::string, std::string>> attributes);

  // Whether `emberline render` or `merge` wrote the file.
  bool is_ours() const { return texts_.contains("command"); }
  // Returns the text of the attribute with this name, such as "spp" or "complete"; "" if there is
  // no such attribute.
  std::string text(const std::string& name) const;
  // The recorded settings. A setting keeps its default if its value is a path, or if its value is
  // not recorded or cannot be read.
  const FrameSettings& settings() const { return settings_; }
  // Returns the names and texts of the settings that differ from the defaults, including input
  // files, in the order of setting_table(). Leaves out the instruction set, which every frame
  // records.
  std::vector<std::pair<std::string, std::string>> given() const;
  // Lists the recorded settings that differ from `now`, each as "`spp` 64 (now 256)". Leaves out
  // input files, because their names depend on the folder in which a command runs. Also leaves out
  // `time-limit` and `bucket-order`, which change no pixel, and the instruction set unless `now`
  // sets it. If `is_compared` is given, compares only the settings for which it is true.
  std::vector<std::string> changes(const FrameSettings& now,
                                   bool (*is_compared)(const Setting&) = nullptr) const;

 private:
  std::map<std::string, std::string> texts_;  // by setting name, with dashes
  FrameSettings settings_;
};

}  // namespace emberline
