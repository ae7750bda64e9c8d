// The table of material parameters that edits may replace. It is used by apply() (scene_edits.h),
// the edits file (io/json/edits_file.h) and the window's panel. To add a parameter, add a member to
// MaterialEdit and a row to the table.
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "renderer/description/scene_edits.h"

namespace emberline {

// One parameter, which is either a number or a colour. If an edit has no value for the parameter,
// the file's value stays.
struct MaterialParameter {
  std::string_view name;    // in an edits file
  double minimum, maximum;  // allowed range in an edit; for a colour, of each channel
  std::optional<float> MaterialEdit::*edited_number = nullptr;
  float MaterialDescription::*number = nullptr;
  std::optional<Rgb> MaterialEdit::*edited_color = nullptr;
  Rgb MaterialDescription::*color = nullptr;
  float unit = 1.0f;  // value in MaterialDescription / value in the edit
};

// Returns all parameters, in the order of the edits file.
std::span<const MaterialParameter> material_parameters();
// Returns the parameter with this name, which must be in the table (asserted).
const MaterialParameter& material_parameter(std::string_view name);

}  // namespace emberline
