#include "renderer/window/panels/action_widgets.h"

#include <fmt/format.h>
#include <imgui.h>

#include <cfloat>

#include "renderer/window/panels/widgets.h"

namespace emberline {
namespace {

std::string effect_and_keys(Action action) {
  return fmt::format("{} ({})", effect_of(action), keys_of(action));
}

}  // namespace

void action_button(Workbench& bench, const char* label, Action action, float width) {
  const bool pressed = ImGui::Button(label, {width < 0.0f ? -FLT_MIN : width, 0.0f});
  widgets::help(effect_and_keys(action));
  if (pressed) bench.act(action);
}

void small_action_button(Workbench& bench, const char* label, Action action) {
  const bool pressed = ImGui::SmallButton(label);
  widgets::help(effect_and_keys(action));
  if (pressed) bench.act(action);
}

void action_entry(Workbench& bench, const char* label, Action action, bool enabled, bool checked) {
  const std::string keys(keys_of(action));
  const bool chosen = ImGui::MenuItem(label, keys.c_str(), checked, enabled);
  widgets::help(std::string(effect_of(action)));  // without the keys, which the entry itself shows
  if (chosen) bench.act(action);
}

}  // namespace emberline
