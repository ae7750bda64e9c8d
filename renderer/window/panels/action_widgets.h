// Buttons and menu entries for actions. Tooltips and keys come from the table of shortcuts.
#pragma once

#include "renderer/window/workbench/workbench.h"

namespace emberline {

// `width` is as for widgets::button().
void action_button(Workbench& bench, const char* label, Action action, float width = 0.0f);
void small_action_button(Workbench& bench, const char* label, Action action);
void action_entry(Workbench& bench, const char* label, Action action, bool enabled = true,
                  bool checked = false);

}  // namespace emberline
