// The table of material parameters that edits may replace. It drives apply() (scene_edits.h), the
// edits file (io/json/edits_file.h) and the window's panel. To add one, add a member of
// MaterialEdit and a row.
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "renderer/description/scene_edits.h"

namespace emberline {

// A number or a colour. Values that are absent in an edit stay as in the file.
struct MaterialParameter {
  std::string_view name;    // in an edits file
  double minimum, maximum;  // range of an edit, per channel of a colour
  std::optional<float> MaterialEdit::*edited_number = nullptr;
  float MaterialDescription::*number = nullptr;
  std::optional<Rgb> MaterialEdit::*edited_color = nullptr;
  Rgb MaterialDescription::*color = nullptr;
  float unit = 1.0f;  // unit of an edited number, in units of MaterialDescription
};

// In the order of the edits file.
std::span<const MaterialParameter> material_parameters();
// `name` must be in the table (asserted).
const MaterialParameter& material_parameter(std::string_view name);

}  // namespace emberline
