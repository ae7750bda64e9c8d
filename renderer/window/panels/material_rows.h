// The rows of the material panel, one per editable parameter, in groups. Plain data and functions;
// panels/materials.cpp draws them.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "renderer/description/scene_edits.h"
#include "renderer/window/panels/label.h"

namespace emberline {

struct MaterialRow {
  std::string_view parameter;  // name in material_parameters()
  const char* label;
  Help help;
  // Range of the slider or of each colour channel. Values in an edits file may lie outside this
  // range.
  float minimum = 0.0f, maximum = 1.0f;
  const char* format = "%.3f";
  bool logarithmic = false;
  // Returns whether the row applies to the file's material with this edit. The pointer is null if
  // the row always applies.
  bool (*applies)(const MaterialDescription& original, const MaterialEdit& edit) = nullptr;
};

struct MaterialGroup {
  const char* name;  // empty for the base, which every material has
  Help help;
  std::span<const MaterialRow> rows;
  bool (*present)(const MaterialDescription& original);  // whether the original has this layer

  bool edited(const MaterialEdit& edit) const;  // whether any row is edited
};

// Returns all groups, the base first.
std::span<const MaterialGroup> material_groups();

// Returns whether the row applies to this material.
bool is_applicable(const MaterialRow& row, const MaterialDescription& original,
                   const MaterialEdit& edit);

// Returns the groups with at least one applicable row: the base, the layers of the file's material,
// then the rest. The order does not depend on the edit, so that no row moves under the mouse.
std::vector<const MaterialGroup*> applicable_groups(const MaterialDescription& original,
                                                    const MaterialEdit& edit);

}  // namespace emberline
