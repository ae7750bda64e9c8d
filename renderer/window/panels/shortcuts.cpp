#include <imgui.h>

#include <algorithm>
#include <string_view>

#include "renderer/window/panels/panels.h"
#include "renderer/window/panels/theme.h"

namespace emberline {
namespace {

void shortcut_row(std::string_view keys, std::string_view effect) {
  ImGui::TableNextRow();
  ImGui::TableNextColumn();
  ImGui::TextColored(accent_colour(), "%.*s", int(keys.size()), keys.data());
  ImGui::TableNextColumn();
  ImGui::TextUnformatted(effect.data(), effect.data() + effect.size());
}

void shortcut_heading(std::string_view text) {
  ImGui::TableNextRow();
  ImGui::TableNextColumn();
  ImGui::TextColored(muted_colour(), "%.*s", int(text.size()), text.data());
}

// Lists one of two columns: the groups before "Picture" or, if `second_half` is true, the remaining
// groups. The columns are then about equally long.
void list_keys(bool second_half) {
  std::string_view group;
  bool in_second = false;
  for (const Shortcut& entry : shortcut_table()) {
    in_second |= entry.group == "Picture";
    if (!entry.listed || in_second != second_half) continue;
    if (entry.group != group) shortcut_heading(group = entry.group);
    shortcut_row(entry.keys, entry.effect);
  }
}

void list_mouse() {
  shortcut_heading("Mouse");
  for (const DragGesture& entry : drag_table()) shortcut_row(entry.keys, entry.effect);
  for (const ListedGesture& entry : listed_gestures()) shortcut_row(entry.keys, entry.effect);
}

void list_flight() {
  shortcut_heading("Fly");
  for (const FlightKey& entry : flight_table()) shortcut_row(entry.keys, entry.effect);
}

}  // namespace

void Interface::draw_shortcuts(Workbench& bench) {
  if (!bench.interface.show_shortcuts) return;
  const float em = ImGui::GetFontSize();
  const ImVec2 screen = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({0.5f * screen.x, 0.5f * screen.y}, ImGuiCond_Appearing, {0.5f, 0.5f});
  ImGui::SetNextWindowSize(
      {std::min(64.0f * em, 0.95f * screen.x), std::min(44.0f * em, 0.9f * screen.y)},
      ImGuiCond_Appearing);
  if (ImGui::Begin("Shortcuts", &bench.interface.show_shortcuts,
                   ImGuiWindowFlags_NoSavedSettings)) {
    if (ImGui::BeginTable("##halves", 2)) {
      ImGui::TableNextColumn();
      if (ImGui::BeginTable("##keys", 2, ImGuiTableFlags_SizingFixedFit)) {
        list_keys(false);
        list_flight();
        ImGui::EndTable();
      }
      ImGui::TableNextColumn();
      if (ImGui::BeginTable("##mouse", 2, ImGuiTableFlags_SizingFixedFit)) {
        list_mouse();
        list_keys(true);
        ImGui::EndTable();
      }
      ImGui::EndTable();
    }
  }
  register_window();
  ImGui::End();
}

}  // namespace emberline
