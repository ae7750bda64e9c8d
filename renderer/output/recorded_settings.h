// The settings that the header of an EXR states (settings_attributes() in report.h), read back.
#pragma once

#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "renderer/engine/frame_settings.h"

namespace emberline {

class RecordedSettings {
 public:
  // Reads the header's attributes. Ignores those whose names do not begin with "emberline:", and
  // the blanks that pad a text (outputs.h).
  explicit RecordedSettings(std::span<const std::pair<std::string, std::string>> attributes);

  // Whether `emberline render` or `merge` wrote the file.
  bool is_ours() const { return texts_.contains("command"); }
  // The text of an attribute, such as "spp" or "complete"; empty if there is none.
  std::string text(const std::string& name) const;
  // The recorded settings. Input files, and settings that cannot be read, have their defaults.
  const FrameSettings& settings() const { return settings_; }
  // Names and texts of the settings that differ from the defaults, input files included, in table
  // order. The instruction set, which every frame records, is left out.
  std::vector<std::pair<std::string, std::string>> given() const;
  // Lists the settings in which a frame rendered with `now` would differ, each as "`spp` 64 (now
  // 256)". Leaves out input files, whose names depend on the folder in which a command runs, and
  // settings that change no pixel: `time-limit`, `bucket-order` and, unless `now` sets it, the
  // instruction set.
  std::vector<std::string> changes(const FrameSettings& now) const;

 private:
  std::map<std::string, std::string> texts_;  // by setting name, with dashes
  FrameSettings settings_;
};

}  // namespace emberline
