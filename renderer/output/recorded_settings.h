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
  // The texts of the header's attributes by name; names that do not begin with "emberline:" are
  // ignored, and so are the blanks at the end of a text (outputs.h).
  explicit RecordedSettings(std::span<const std::pair<std::string, std::string>> attributes);

  // Whether `emberline render` or `merge` wrote the file.
  bool is_ours() const { return texts_.contains("command"); }
  // The text of an attribute, such as "spp" or "complete"; empty if there is none.
  std::string text(const std::string& name) const;
  // The settings that can be read; the others, and input files, have their defaults.
  const FrameSettings& settings() const { return settings_; }
  // Names and texts of the settings that differ from the defaults, input files included, in table
  // order. The instruction set, which every frame records, is left out.
  std::vector<std::pair<std::string, std::string>> given() const;
  // The settings in which a frame of `now` would differ, each as "`spp` 64 (now 256)". Leaves out
  // input files, whose names depend on the folder that a command runs in, and what changes no
  // pixel: `time-limit`, `bucket-order`, the instruction set unless it is given.
  std::vector<std::string> changes(const FrameSettings& now) const;

 private:
  std::map<std::string, std::string> texts_;  // by setting name, with dashes
  FrameSettings settings_;
};

}  // namespace emberline
