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

constexpr float kMinIntensity = 0.01f, kMaxIntensity = 100.0f;

bool same_light(const std::optional<LightEdit>& solo, const LightEdit& edit) {
  return solo && solo->kind == edit.kind && solo->target == edit.target;
}

bool solo_button(bool on) {
  if (on) {
    ImGui::PushStyleColor(ImGuiCol_Button, accent_colour());
    ImGui::PushStyleColor(ImGuiCol_ButtonHovered, accent_colour());
    ImGui::PushStyleColor(ImGuiCol_Text, ImVec4(0.08f, 0.08f, 0.08f, 1.0f));
  }
  const bool pressed =
      widgets::button("Solo", "Switch all other lights off for now (Esc). Solo is not saved.");
  if (on) ImGui::PopStyleColor(3);
  return pressed;
}

float solo_width() {
  return ImGui::CalcTextSize("Solo").x + 2.0f * ImGui::GetStyle().FramePadding.x;
}

// Draws the light's name and type, clipped so that they do not overlap the solo button.
void draw_name(const ListedLight& light, bool on) {
  const float text_width =
      ImGui::GetContentRegionAvail().x - solo_width() - ImGui::GetStyle().ItemSpacing.x;
  const ImVec2 at = ImGui::GetCursorScreenPos();
  ImGui::PushClipRect(at, {at.x + text_width, at.y + 2.0f * ImGui::GetFontSize()}, true);
  ImGui::AlignTextToFramePadding();
  ImGui::TextColored(on ? ImGui::GetStyleColorVec4(ImGuiCol_Text) : muted_colour(), "%s",
                     light.name.c_str());
  ImGui::SameLine();
  ImGui::TextColored(muted_colour(), "%s", light.type.c_str());
  ImGui::PopClipRect();
  if (ImGui::IsMouseHoveringRect(at, {at.x + text_width, at.y + ImGui::GetFrameHeight()}) &&
      ImGui::IsWindowHovered()) {
    widgets::tooltip(light.name);
  }
}

void choose_solo(SceneEditor& edits, const LightEdit& light) {
  const bool solo = same_light(edits.solo(), light);
  if (solo_button(solo)) edits.set_solo(solo ? std::nullopt : std::optional<LightEdit>(light));
}

bool choose_intensity_and_colour(LightEdit& edit) {
  const float swatch = ImGui::GetFrameHeight();
  ImGui::SetNextItemWidth(-swatch - ImGui::GetStyle().ItemInnerSpacing.x);
  bool changed =
      widgets::slide_bare("##intensity", "Intensity relative to the file's. Right-click to reset.",
                          edit.intensity, kMinIntensity, kMaxIntensity, "Intensity × %.3g");
  if (ImGui::IsItemClicked(ImGuiMouseButton_Right)) {
    edit.intensity = 1.0f;
    changed = true;
  }
  edit.intensity = std::max(edit.intensity, 0.0f);
  ImGui::SameLine(0.0f, ImGui::GetStyle().ItemInnerSpacing.x);
  changed |= widgets::swatch("##colour", "Tint, which multiplies the light's colour", edit.color);
  return changed;
}

void draw_light(Workbench& bench, const ListedLight& light) {
  LightEdit edit =
      light_edit(bench.session.edits(), bench.session.scene()->outline, light.kind, light.index);
  ImGui::PushID(int(light.kind) * 100000 + light.index);
  bool changed = widgets::checkbox("##on", "Switch the light on or off", edit.on);
  ImGui::SameLine();
  draw_name(light, edit.on);
  ImGui::SameLine(ImGui::GetContentRegionMax().x - solo_width());
  choose_solo(bench.edits, edit);
  changed |= choose_intensity_and_colour(edit);
  ImGui::PopID();
  ImGui::Dummy({0.0f, 0.15f * ImGui::GetFontSize()});
  if (changed) bench.edits.change(edit, fmt::format("light {} {}", int(light.kind), light.index));
}

bool choose_button(float width) {
  return widgets::button("Choose…", "Choose an .hdr or .exr file as the environment", width);
}

void choose_environment_file(Workbench& bench, const EnvironmentEdit& edit,
                             const std::optional<EnvironmentDescription>& own) {
  const std::string file = edit.file.empty() ? (own ? own->file : "") : edit.file;
  const std::string name = std::filesystem::path(file).filename().string();
  widgets::text({"File", "Image of the environment", !edit.file.empty()},
                name.empty() ? "Constant colour" : name);
  if (!file.empty()) widgets::help(file);
  const float half = widgets::half_width();
  if (choose_button(half)) bench.interface.environment_dialog_requested = true;
  ImGui::SameLine();
  ImGui::BeginDisabled(edit.file.empty());
  const bool clear = own ? widgets::button("Reset", "Use the scene's own environment again", half)
                         : widgets::button("Remove", "Remove the environment", half);
  if (clear) bench.edits.clear_environment();
  ImGui::EndDisabled();
}

void draw_environment(Workbench& bench) {
  const auto scene = bench.session.scene();
  const std::optional<EnvironmentDescription>& own = scene->outline.environment;
  SceneEdits edits = bench.session.edits();
  EnvironmentEdit& edit = edits.environment;
  if (!own && edit.file.empty()) {
    widgets::muted_paragraph("No environment. Choose an .hdr or .exr file, or drop one here.");
    if (choose_button(-1.0f)) bench.interface.environment_dialog_requested = true;
    return;
  }
  choose_environment_file(bench, edit, own);
  if (widgets::slide_edit("Strength", "Brightness of the environment", edit.strength,
                          own ? own->strength : 1.0f, kMinIntensity, kMaxIntensity, "%.3g", true)) {
    bench.edits.change(edits, "environment strength");
  }
  if (widgets::slide_edit(
          "Rotation",
          "Turn about the vertical axis. Shift+right drag over the picture does the same.",
          edit.rotation_degrees, own ? own->rotation_degrees : 0.0f, -180.0f, 180.0f, "%.1f°")) {
    bench.edits.change(edits, "environment rotation");
  }
}

// Lets the user switch light groups on or off. With light groups, changes of lights need no new
// samples. Without them, the noise is the same as in a final frame.
void choose_light_groups(Workbench& bench) {
  ViewSettings settings = bench.session.settings();
  ImGui::BeginDisabled(!can_relight(settings.render));
  if (widgets::check({"Instant Relighting",
                      "Render each light separately, so that changes of its intensity or colour, "
                      "switching and solo need no new samples. The noise differs from that of a "
                      "final frame. Not available with the Bucket driver."},
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
    ImGui::TextColored(accent_colour(), "Solo: all other lights are off.");
    ImGui::SameLine();
    if (widgets::small_button("End Solo", "Switch the other lights on again (Esc)"))
      bench.edits.set_solo(std::nullopt);
  }
  for (const ListedLight& light : lights) draw_light(bench, light);
  if (lights.empty()) ImGui::TextColored(muted_colour(), "The scene has no lights.");
  widgets::heading("Environment");
  draw_environment(bench);
}

}  // namespace emberline
