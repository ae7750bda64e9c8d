// The materials tab.
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>

#include "renderer/description/material_parameters.h"
#include "renderer/window/panels/choose_target.h"
#include "renderer/window/panels/edit_entries.h"
#include "renderer/window/panels/material_rows.h"
#include "renderer/window/panels/panels.h"
#include "renderer/window/panels/theme.h"
#include "renderer/window/panels/widgets.h"

namespace emberline {
namespace {

bool colour_factor(const MaterialRow& row, std::optional<Rgb>& factor, const Rgb& original) {
  Rgb value = factor.value_or(original);
  bool reset = false;
  const bool moved =
      widgets::colour({row.label, row.help, factor.has_value(), &reset}, value, row.maximum > 1.0f);
  if (moved) {
    const auto clamp_channel = [&](float x) { return std::clamp(x, row.minimum, row.maximum); };
    factor = Rgb(clamp_channel(value.x), clamp_channel(value.y), clamp_channel(value.z));
  }
  if (reset) factor.reset();
  return moved || reset;
}

bool edit_group(const MaterialGroup& group, MaterialEdit& edit,
                const MaterialDescription& original) {
  bool changed = false;
  ImGui::PushID(group.name);
  for (const MaterialRow& row : group.rows) {
    if (!is_applicable(row, original, edit)) continue;
    const MaterialParameter& p = material_parameter(row.parameter);
    changed |= p.color ? colour_factor(row, edit.*p.edited_color, original.*p.color)
                       : widgets::slide_edit(row.label, row.help, edit.*p.edited_number,
                                             original.*p.number / p.unit, row.minimum, row.maximum,
                                             row.format, row.logarithmic);
  }
  ImGui::PopID();
  return changed;
}

// Draws a collapsible heading in the colours of input fields.
bool group_heading(const MaterialGroup& group, bool open, bool edited) {
  ImGui::PushStyleColor(ImGuiCol_Header, ImGui::GetStyleColorVec4(ImGuiCol_FrameBg));
  ImGui::PushStyleColor(ImGuiCol_HeaderHovered, ImGui::GetStyleColorVec4(ImGuiCol_FrameBgHovered));
  ImGui::PushStyleColor(ImGuiCol_HeaderActive, ImGui::GetStyleColorVec4(ImGuiCol_FrameBgActive));
  ImGui::PushStyleColor(ImGuiCol_Text,
                        edited ? accent_colour() : ImGui::GetStyleColorVec4(ImGuiCol_Text));
  const bool is_open = ImGui::CollapsingHeader(
      group.name, open ? ImGuiTreeNodeFlags_DefaultOpen : ImGuiTreeNodeFlags_None);
  ImGui::PopStyleColor(4);
  widgets::help(group.help);
  return is_open;
}

// Draws the base, then the layers, which can be collapsed. A layer is open at first if the file's
// material has it or if it is edited.
bool edit_factors(MaterialEdit& edit, const MaterialDescription& original) {
  bool changed = false;
  for (const MaterialGroup* group : applicable_groups(original, edit)) {
    const bool base = group->name[0] == '\0', edited = group->edited(edit);
    if (base || group_heading(*group, group->present(original) || edited, edited)) {
      changed |= edit_group(*group, edit, original);
    }
  }
  return changed;
}

void list_materials(Workbench& bench) {
  const SceneDescription& outline = bench.session.scene()->outline;
  int& selected = bench.selection.material;
  const float rows = std::min(8.0f, std::max(2.0f, float(outline.materials.size())));
  if (!ImGui::BeginListBox("##materials",
                           {-FLT_MIN, (rows + 0.4f) * ImGui::GetTextLineHeightWithSpacing()})) {
    return;
  }
  for (int i = 0; i < int(outline.materials.size()); ++i) {
    ImGui::PushID(i);
    const std::string name = display_name(outline.materials[size_t(i)].name, "Material", i);
    const bool edited = has_changes(material_edit(bench.session.edits(), outline, i));
    if (edited) ImGui::PushStyleColor(ImGuiCol_Text, accent_colour());
    if (ImGui::Selectable(name.c_str(), i == selected)) selected = i;
    if (edited) ImGui::PopStyleColor();
    if (i == selected && ImGui::IsWindowAppearing()) ImGui::SetScrollHereY();
    ImGui::PopID();
  }
  ImGui::EndListBox();
}

void choose_variant(Workbench& bench) {
  const auto& variants = bench.session.scene()->outline.variants;
  if (variants.empty()) return;
  SceneEdits edits = bench.session.edits();
  if (choose_target({"Variant", "A set of materials defined in the file"}, edits.variant, variants,
                    "Variant", "Default")) {
    bench.edits.change(edits, "variant");
  }
}

}  // namespace

void draw_materials(Workbench& bench) {
  const auto scene = bench.session.scene();
  if (!scene) return;
  const SceneDescription& outline = scene->outline;
  choose_variant(bench);
  list_materials(bench);
  const int index = bench.selection.material;
  if (index < 0 || size_t(index) >= outline.materials.size()) {
    widgets::muted_paragraph("Click on the picture or on a name to choose a material.");
    return;
  }
  const MaterialDescription& original = outline.materials[size_t(index)];
  MaterialEdit edit = material_edit(bench.session.edits(), outline, index);
  widgets::heading(display_name(original.name, "Material", index).c_str());
  ImGui::PushID(index);  // so that each material remembers its open headings
  bool changed = edit_factors(edit, original);
  ImGui::PopID();
  if (has_changes(edit) &&
      widgets::button("Reset Material", "Reset all edits of this material", -1.0f)) {
    edit = unedited(edit.target);
    changed = true;
  }
  if (changed) bench.edits.change(edit, fmt::format("material {}", index));
}

}  // namespace emberline
