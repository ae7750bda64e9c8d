// The rows of the material panel: one for each parameter that edits may replace, in groups. Plain
// data and functions of it; panels/materials.cpp draws them.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "renderer/description/scene_edits.h"

namespace emberline {

struct MaterialRow {
  std::string_view parameter;  // of material_parameters()
  const char* label;
  // The range of the slider, or of each channel of a colour. An edit in a file may be beyond it.
  float least = 0.0f, most = 1.0f;
  const char* help = nullptr;
  const char* format = "%.3f";
  bool logarithmic = false;
  // Whether it means anything for the file's material; null: always.
  bool (*offered)(const MaterialDescription& own, const MaterialEdit& edit) = nullptr;
};

struct MaterialGroup {
  const char* name;  // empty: the base, which every material has
  std::span<const MaterialRow> rows;
  bool (*present)(const MaterialDescription& own);  // in the file

  bool edited(const MaterialEdit& edit) const;  // any of the rows
};

// All groups, the base first.
std::span<const MaterialGroup> material_groups();

// Whether the row means anything for this material.
bool is_offered(const MaterialRow& row, const MaterialDescription& own, const MaterialEdit& edit);

// The groups that have a visible row: the base, the file's layers, the rest. The order does not
// depend on the edit, so that nothing moves under the mouse.
std::vector<const MaterialGroup*> offered_groups(const MaterialDescription& own,
                                                 const MaterialEdit& edit);

}  // namespace emberline
