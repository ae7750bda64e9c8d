// The lights tab, including the environment.
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <filesystem>

#include "renderer/session/prepared_settings.h"
#include "renderer/window/panels/edit_entries.h"
#include "renderer/window/panels/panels.h"
#include "renderer/window/panels/theme.h"
#include "renderer/window/panels/widgets.h"

namespace emberline {
namespace {

constexpr float kLeastIntensity = 0.01f, kMostIntensity = 100.0f;

bool same_light(const std::optional<LightEdit>& solo, const LightEdit& edit) {
  return solo && solo->kind == edit.kind && solo->target == edit.target;
}

bool lit_button(const char* label, bool on) {
  if (on) {
    ImGui::PushStyleColor(ImGuiCol_Button, accent_colour());
    ImGui::PushStyleColor(ImGuiCol_ButtonHovered, accent_colour());
    ImGui::PushStyleColor(ImGuiCol_Text, ImVec4(0.08f, 0.08f, 0.08f, 1.0f));
  }
  const bool pressed = ImGui::Button(label);
  if (on) ImGui::PopStyleColor(3);
  return pressed;
}

float solo_width() {
  return ImGui::CalcTextSize("Solo").x + 2.0f * ImGui::GetStyle().FramePadding.x;
}

// Draws name and type, clipped before the button to their right.
void draw_name(const ListedLight& light, bool on) {
  const float room =
      ImGui::GetContentRegionAvail().x - solo_width() - ImGui::GetStyle().ItemSpacing.x;
  const ImVec2 at = ImGui::GetCursorScreenPos();
  ImGui::PushClipRect(at, {at.x + room, at.y + 2.0f * ImGui::GetFontSize()}, true);
  ImGui::AlignTextToFramePadding();
  ImGui::TextColored(on ? ImGui::GetStyleColorVec4(ImGuiCol_Text) : quiet_colour(), "%s",
                     light.name.c_str());
  ImGui::SameLine();
  ImGui::TextColored(quiet_colour(), "%s", light.type.c_str());
  ImGui::PopClipRect();
  if (ImGui::IsMouseHoveringRect(at, {at.x + room, at.y + ImGui::GetFrameHeight()}) &&
      ImGui::IsWindowHovered()) {
    widgets::tooltip(light.name);
  }
}

void choose_solo(SceneEditor& edits, const LightEdit& light) {
  const bool solo = same_light(edits.solo(), light);
  if (lit_button("Solo", solo)) {
    edits.set_solo(solo ? std::nullopt : std::optional<LightEdit>(light));
  }
  widgets::help("only this light shines; Esc ends it. Not saved");
}

bool choose_intensity_and_colour(LightEdit& edit) {
  const float swatch = ImGui::GetFrameHeight();
  ImGui::SetNextItemWidth(-swatch - ImGui::GetStyle().ItemInnerSpacing.x);
  bool changed = ImGui::SliderFloat("##intensity", &edit.intensity, kLeastIntensity, kMostIntensity,
                                    "intensity × %.3g", ImGuiSliderFlags_Logarithmic);
  widgets::help("times the file's own; Ctrl+click to type a number, right click for × 1");
  if (ImGui::IsItemClicked(ImGuiMouseButton_Right)) {
    edit.intensity = 1.0f;
    changed = true;
  }
  edit.intensity = std::max(edit.intensity, 0.0f);
  ImGui::SameLine(0.0f, ImGui::GetStyle().ItemInnerSpacing.x);
  changed |= ImGui::ColorEdit3("##colour", &edit.color.x,
                               ImGuiColorEditFlags_NoInputs | ImGuiColorEditFlags_NoLabel |
                                   ImGuiColorEditFlags_Float | ImGuiColorEditFlags_PickerHueWheel);
  return changed;
}

void draw_light(Workbench& bench, const ListedLight& light) {
  LightEdit edit =
      light_edit(bench.session.edits(), bench.session.scene()->outline, light.kind, light.index);
  ImGui::PushID(int(light.kind) * 100000 + light.index);
  bool changed = ImGui::Checkbox("##on", &edit.on);
  widgets::help("on or off");
  ImGui::SameLine();
  draw_name(light, edit.on);
  ImGui::SameLine(ImGui::GetContentRegionMax().x - solo_width());
  choose_solo(bench.edits, edit);
  changed |= choose_intensity_and_colour(edit);
  ImGui::PopID();
  ImGui::Dummy({0.0f, 0.15f * ImGui::GetFontSize()});
  if (changed) bench.edits.change(edit, fmt::format("light {} {}", int(light.kind), light.index));
}

void choose_environment_file(Workbench& bench, const EnvironmentEdit& edit,
                             const std::optional<EnvironmentDescription>& own) {
  const std::string file = edit.file.empty() ? (own ? own->file : "") : edit.file;
  const std::string name = std::filesystem::path(file).filename().string();
  widgets::text({"File", file.c_str(), !edit.file.empty()},
                name.empty() ? "constant colour" : name);
  const float half = widgets::half_width();
  if (ImGui::Button("Choose…", {half, 0.0f})) bench.interface.ask_for_environment = true;
  ImGui::SameLine();
  ImGui::BeginDisabled(edit.file.empty());
  if (ImGui::Button(own ? "As opened" : "Take away", {half, 0.0f})) bench.edits.clear_environment();
  ImGui::EndDisabled();
}

void draw_environment(Workbench& bench) {
  const auto scene = bench.session.scene();
  const std::optional<EnvironmentDescription>& own = scene->outline.environment;
  SceneEdits edits = bench.session.edits();
  EnvironmentEdit& edit = edits.environment;
  if (!own && edit.file.empty()) {
    widgets::quiet_paragraph("No environment. Choose an .hdr or .exr file, or drop one here.");
    if (ImGui::Button("Choose…", {-FLT_MIN, 0.0f})) bench.interface.ask_for_environment = true;
    return;
  }
  choose_environment_file(bench, edit, own);
  if (widgets::slide_edit("Strength", nullptr, edit.strength, own ? own->strength : 1.0f,
                          kLeastIntensity, kMostIntensity, "%.3g", true)) {
    bench.edits.change(edits, "environment strength");
  }
  if (widgets::slide_edit("Rotation", "Shift+right drag over the picture turns it too",
                          edit.rotation_degrees, own ? own->rotation_degrees : 0.0f, -180.0f,
                          180.0f, "%.1f°")) {
    bench.edits.change(edits, "environment rotation");
  }
}

// Chooses between light groups, which need no new samples, and rendering like a final frame.
void choose_light_groups(Workbench& bench) {
  ViewSettings settings = bench.session.settings();
  ImGui::BeginDisabled(!can_relight(settings.render));
  if (widgets::check({"Instant relighting",
                      "keeps what each light gives apart: intensity, colour, switches and solo "
                      "then change the finished picture without a new ray. Not with the driver "
                      "bucket. Other noise than a final frame's"},
                     settings.light_groups)) {
    bench.settings.change(settings);
  }
  ImGui::EndDisabled();
}

}  // namespace

void draw_lights(Workbench& bench) {
  const auto scene = bench.session.scene();
  if (!scene) return;
  choose_light_groups(bench);
  const std::vector<ListedLight> lights = list_lights(scene->outline, bench.session.edits());
  if (bench.edits.solo()) {
    ImGui::TextColored(accent_colour(), "Only one light shines.");
    ImGui::SameLine();
    if (ImGui::SmallButton("End solo")) bench.edits.set_solo(std::nullopt);
  }
  for (const ListedLight& light : lights) draw_light(bench, light);
  if (lights.empty()) ImGui::TextColored(quiet_colour(), "The scene has no light.");
  widgets::heading("Environment");
  draw_environment(bench);
}

}  // namespace emberline
