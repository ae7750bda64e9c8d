// A panel row that chooses an item of the scene's file.
#pragma once

#include <string>
#include <vector>

#include "renderer/description/scene_edits.h"
#include "renderer/window/panels/edit_entries.h"
#include "renderer/window/panels/widgets.h"

namespace emberline {

// Lets the user choose an item of `list`. The entry `none_label` resets `target`, which then means
// the file's default. `what` names the kind of item, such as "Camera". If `placeholder` is not
// empty, it is shown instead of the chosen item.
template <class Named>
bool choose_target(const widgets::Row& row, std::optional<EditTarget>& target,
                   const std::vector<Named>& list, const char* what, const char* none_label,
                   const std::string& placeholder = {}) {
  std::vector<std::string> names;
  for (int i = 0; i < int(list.size()); ++i) {
    names.push_back(display_name(list[size_t(i)].name, what, i));
  }
  int index = -1;
  if (target && placeholder.empty()) index = int(find_entry(*target, list).value_or(size_t(-1)));
  if (!widgets::choose_index(row, index, widgets::choices_of_names(names), placeholder,
                             none_label)) {
    return false;
  }
  target.reset();
  if (index >= 0) target = EditTarget{list[size_t(index)].name, index, ""};
  return true;
}

}  // namespace emberline
