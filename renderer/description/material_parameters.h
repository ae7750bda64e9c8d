// The parameters of a material that edits may replace, in one table: apply() (scene_edits.h), the
// file of edits (io/json/edits_file.h) and the window's panel go by it. To add one: a member of
// MaterialEdit and a row.
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "renderer/description/scene_edits.h"

namespace emberline {

// A number or a colour. What is absent in an edit stays as the file has it.
struct MaterialParameter {
  std::string_view name;  // in a file of edits
  double least, most;     // of an edit, each channel of a colour
  std::optional<float> MaterialEdit::*edited_number = nullptr;
  float MaterialDescription::*number = nullptr;
  std::optional<Rgb> MaterialEdit::*edited_color = nullptr;
  Rgb MaterialDescription::*color = nullptr;
  float unit = 1.0f;  // of an edited number, in that of MaterialDescription
};

// In the order in which a file of edits has them.
std::span<const MaterialParameter> material_parameters();
// `name` is one of the table's (asserted).
const MaterialParameter& material_parameter(std::string_view name);

}  // namespace emberline
