// Lights, materials and camera: what edits change.
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "integrators/integrator.h"
#include "renderer/core/errors.h"
#include "renderer/core/names.h"
#include "renderer/description/material_parameters.h"
#include "renderer/session/prepared_settings.h"
#include "renderer/window/panels/edit_entries.h"
#include "renderer/window/panels/material_rows.h"
#include "renderer/window/panels/panels.h"
#include "renderer/window/panels/theme.h"
#include "renderer/window/panels/widgets.h"

namespace emberline {
namespace {

using widgets::Row;

constexpr float kLeastIntensity = 0.01f, kMostIntensity = 100.0f;
constexpr double kFirstStop = 2.8;                           // of a lens that is switched on
constexpr float kLeastHeight = 1e-3f, kMostHeight = 100.0f;  // orthographic, in radii of the scene

bool same_light(const std::optional<LightEdit>& solo, const LightEdit& edit) {
  return solo && solo->kind == edit.kind && solo->target == edit.target;
}

// A button that is lit while it is on.
bool toggle(const char* label, bool on) {
  if (on) {
    ImGui::PushStyleColor(ImGuiCol_Button, accent_colour());
    ImGui::PushStyleColor(ImGuiCol_ButtonHovered, accent_colour());
    ImGui::PushStyleColor(ImGuiCol_Text, ImVec4(0.08f, 0.08f, 0.08f, 1.0f));
  }
  const bool pressed = ImGui::Button(label);
  if (on) ImGui::PopStyleColor(3);
  return pressed;
}

void draw_light(Workbench& bench, const ListedLight& light) {
  const SceneDescription& outline = bench.scene()->outline;
  LightEdit edit = light_edit(bench.edits(), outline, light.kind, light.index);
  bool changed = false;

  ImGui::PushID(int(light.kind) * 100000 + light.index);
  changed |= ImGui::Checkbox("##on", &edit.on);
  if (ImGui::IsItemHovered()) widgets::help("on or off");
  ImGui::SameLine();
  const float solo_width = ImGui::CalcTextSize("Solo").x + 2.0f * ImGui::GetStyle().FramePadding.x;
  const float room =
      ImGui::GetContentRegionAvail().x - solo_width - ImGui::GetStyle().ItemSpacing.x;
  const ImVec2 at = ImGui::GetCursorScreenPos();
  ImGui::PushClipRect(at, {at.x + room, at.y + 2.0f * ImGui::GetFontSize()}, true);
  ImGui::AlignTextToFramePadding();
  ImGui::TextColored(edit.on ? ImGui::GetStyleColorVec4(ImGuiCol_Text) : quiet_colour(), "%s",
                     light.name.c_str());
  ImGui::SameLine();
  ImGui::TextColored(quiet_colour(), "%s", light.type.c_str());
  ImGui::PopClipRect();
  if (ImGui::IsMouseHoveringRect(at, {at.x + room, at.y + ImGui::GetFrameHeight()}) &&
      ImGui::IsWindowHovered()) {
    widgets::help(light.name);
  }
  ImGui::SameLine(ImGui::GetContentRegionMax().x - solo_width);
  const bool solo = same_light(bench.solo(), edit);
  if (toggle("Solo", solo)) {
    bench.set_solo(solo ? std::nullopt : std::optional<LightEdit>(edit));
  }
  if (ImGui::IsItemHovered()) widgets::help("only this light shines; Esc ends it. Not saved");

  const float swatch = ImGui::GetFrameHeight();
  ImGui::SetNextItemWidth(-swatch - ImGui::GetStyle().ItemInnerSpacing.x);
  changed |= ImGui::SliderFloat("##intensity", &edit.intensity, kLeastIntensity, kMostIntensity,
                                "intensity × %.3g", ImGuiSliderFlags_Logarithmic);
  if (ImGui::IsItemHovered()) {
    widgets::help("times the file's own; Ctrl+click to type a number, right click for × 1");
  }
  if (ImGui::IsItemClicked(ImGuiMouseButton_Right)) {
    edit.intensity = 1.0f;
    changed = true;
  }
  edit.intensity = std::max(edit.intensity, 0.0f);
  ImGui::SameLine(0.0f, ImGui::GetStyle().ItemInnerSpacing.x);
  changed |= ImGui::ColorEdit3("##colour", &edit.color.x,
                               ImGuiColorEditFlags_NoInputs | ImGuiColorEditFlags_NoLabel |
                                   ImGuiColorEditFlags_Float | ImGuiColorEditFlags_PickerHueWheel);
  ImGui::PopID();
  ImGui::Dummy({0.0f, 0.15f * ImGui::GetFontSize()});

  if (!changed) return;
  SceneEdits edits = bench.edits();
  put(edits, outline, edit);
  bench.change(edits, fmt::format("light {} {}", int(light.kind), light.index));
}

void draw_environment(Workbench& bench) {
  const std::optional<EnvironmentDescription>& own = bench.scene()->outline.environment;
  SceneEdits edits = bench.edits();
  EnvironmentEdit& edit = edits.environment;
  if (!own && edit.file.empty()) {
    widgets::quiet_paragraph("No environment. Choose an .hdr or .exr file, or drop one here.");
    if (ImGui::Button("Choose…", {-FLT_MIN, 0.0f})) bench.ask_for_environment = true;
    return;
  }
  const std::string file = edit.file.empty() ? (own ? own->file : "") : edit.file;
  const std::string name = std::filesystem::path(file).filename().string();
  widgets::text({"File", file.c_str(), !edit.file.empty()},
                name.empty() ? "constant colour" : name);
  const float half = 0.5f * (ImGui::GetContentRegionAvail().x - ImGui::GetStyle().ItemSpacing.x);
  if (ImGui::Button("Choose…", {half, 0.0f})) bench.ask_for_environment = true;
  ImGui::SameLine();
  ImGui::BeginDisabled(edit.file.empty());
  if (ImGui::Button(own ? "As opened" : "Take away", {half, 0.0f})) {
    bench.clear_environment();
  }
  ImGui::EndDisabled();

  float strength = edit.strength.value_or(own ? own->strength : 1.0f);
  bool reset = false;
  if (widgets::slide({"Strength", nullptr, edit.strength.has_value(), &reset}, strength,
                     kLeastIntensity, kMostIntensity, "%.3g", true)) {
    edit.strength = strength;
    bench.change(edits, "environment strength");
  }
  if (reset) {
    edit.strength.reset();
    bench.change(edits, "environment strength");
  }
  float rotation = edit.rotation_degrees.value_or(own ? own->rotation_degrees : 0.0f);
  reset = false;
  if (widgets::slide({"Rotation", "Shift+right drag over the picture turns it too",
                      edit.rotation_degrees.has_value(), &reset},
                     rotation, -180.0f, 180.0f, "%.1f°")) {
    edit.rotation_degrees = rotation;
    bench.change(edits, "environment rotation");
  }
  if (reset) {
    edit.rotation_degrees.reset();
    bench.change(edits, "environment rotation");
  }
}

// One factor of a material that an edit replaces.
bool slide_factor(const MaterialRow& row, std::optional<float>& factor, float own) {
  float value = factor.value_or(own);
  bool reset = false;
  const bool moved = widgets::slide({row.label, row.help, factor.has_value(), &reset}, value,
                                    row.least, row.most, row.format, row.logarithmic);
  if (moved) factor = value;
  if (reset) factor.reset();
  return moved || reset;
}

bool colour_factor(const MaterialRow& row, std::optional<Rgb>& factor, const Rgb& own) {
  Rgb value = factor.value_or(own);
  bool reset = false;
  const bool moved =
      widgets::colour({row.label, row.help, factor.has_value(), &reset}, value, row.most > 1.0f);
  if (moved) {
    const auto held = [&](float x) { return std::clamp(x, row.least, row.most); };
    factor = Rgb(held(value.x), held(value.y), held(value.z));
  }
  if (reset) factor.reset();
  return moved || reset;
}

bool edit_group(const MaterialGroup& group, MaterialEdit& edit, const MaterialDescription& own) {
  bool changed = false;
  ImGui::PushID(group.name);
  for (const MaterialRow& row : group.rows) {
    if (!is_offered(row, own, edit)) continue;
    const MaterialParameter& p = material_parameter(row.parameter);
    changed |= p.color ? colour_factor(row, edit.*p.edited_color, own.*p.color)
                       : slide_factor(row, edit.*p.edited_number, own.*p.number / p.unit);
  }
  ImGui::PopID();
  return changed;
}

// A heading that opens and closes, in the colours of the fields below it.
bool group_heading(const char* name, bool open, bool edited) {
  ImGui::PushStyleColor(ImGuiCol_Header, ImGui::GetStyleColorVec4(ImGuiCol_FrameBg));
  ImGui::PushStyleColor(ImGuiCol_HeaderHovered, ImGui::GetStyleColorVec4(ImGuiCol_FrameBgHovered));
  ImGui::PushStyleColor(ImGuiCol_HeaderActive, ImGui::GetStyleColorVec4(ImGuiCol_FrameBgActive));
  ImGui::PushStyleColor(ImGuiCol_Text,
                        edited ? accent_colour() : ImGui::GetStyleColorVec4(ImGuiCol_Text));
  const bool is_open = ImGui::CollapsingHeader(
      name, open ? ImGuiTreeNodeFlags_DefaultOpen : ImGuiTreeNodeFlags_None);
  ImGui::PopStyleColor(4);
  return is_open;
}

// The base, and under headings what lies on it: open where the material has it.
bool edit_factors(MaterialEdit& edit, const MaterialDescription& own) {
  bool changed = false;
  for (const MaterialGroup* group : offered_groups(own, edit)) {
    const bool base = group->name[0] == '\0', edited = group->edited(edit);
    if (base || group_heading(group->name, group->present(own) || edited, edited)) {
      changed |= edit_group(*group, edit, own);
    }
  }
  return changed;
}

void list_materials(Workbench& bench) {
  const SceneDescription& outline = bench.scene()->outline;
  const float rows = std::min(8.0f, std::max(2.0f, float(outline.materials.size())));
  if (!ImGui::BeginListBox("##materials",
                           {-FLT_MIN, (rows + 0.4f) * ImGui::GetTextLineHeightWithSpacing()})) {
    return;
  }
  for (int i = 0; i < int(outline.materials.size()); ++i) {
    ImGui::PushID(i);
    const std::string name = shown_name(outline.materials[size_t(i)].name, "material", i);
    const bool edited = changes_something(material_edit(bench.edits(), outline, i));
    if (edited) ImGui::PushStyleColor(ImGuiCol_Text, accent_colour());
    if (ImGui::Selectable(name.c_str(), i == bench.selected_material())) bench.select_material(i);
    if (edited) ImGui::PopStyleColor();
    if (i == bench.selected_material() && ImGui::IsWindowAppearing()) ImGui::SetScrollHereY();
    ImGui::PopID();
  }
  ImGui::EndListBox();
}

// One of the file's `what`s, or none: what an edit names in place of the file's choice. `otherwise`
// is shown instead of either.
template <class Named>
bool choose_target(const Row& row, std::optional<EditTarget>& target,
                   const std::vector<Named>& list, const char* what, const char* none_means,
                   const std::string& otherwise = {}) {
  std::vector<std::string> names;
  for (int i = 0; i < int(list.size()); ++i) {
    names.push_back(shown_name(list[size_t(i)].name, what, i));
  }
  int index = -1;
  if (target && otherwise.empty()) index = int(find_entry(*target, list).value_or(size_t(-1)));
  if (!widgets::choose_index(row, index, widgets::choices_of_names(names), otherwise, none_means)) {
    return false;
  }
  target.reset();
  if (index >= 0) target = EditTarget{list[size_t(index)].name, index, ""};
  return true;
}

void choose_variant(Workbench& bench) {
  const auto& variants = bench.scene()->outline.variants;
  if (variants.empty()) return;
  SceneEdits edits = bench.edits();
  if (choose_target({"Variant", "a set of materials that the file offers"}, edits.variant, variants,
                    "variant", "the file's own")) {
    bench.change(edits, "variant");
  }
}

// Changing lights without a new ray, or rendering anew as a final frame would.
void choose_light_groups(Workbench& bench) {
  ViewSettings settings = bench.settings();
  const RenderOptions& options = settings.render;
  const bool possible =
      !main_driver(options).tiles && find_integrator(options.integrator).tells_lights_apart;
  ImGui::BeginDisabled(!possible);
  if (widgets::check({"Instant relighting",
                      "keeps what each light gives apart: intensity, colour, switches and solo "
                      "then change the finished picture without a new ray. Not with the driver "
                      "bucket. Other noise than a final frame's"},
                     settings.light_groups)) {
    bench.change(settings);
  }
  ImGui::EndDisabled();
}

}  // namespace

void draw_lights(Workbench& bench) {
  if (!bench.scene()) return;
  choose_light_groups(bench);
  const std::vector<ListedLight> lights = list_lights(bench.scene()->outline, bench.edits());
  if (bench.solo()) {
    ImGui::TextColored(accent_colour(), "Only one light shines.");
    ImGui::SameLine();
    if (ImGui::SmallButton("End solo")) bench.set_solo(std::nullopt);
  }
  for (const ListedLight& light : lights) draw_light(bench, light);
  if (lights.empty()) ImGui::TextColored(quiet_colour(), "The scene has no light.");
  widgets::heading("Environment");
  draw_environment(bench);
}

void draw_materials(Workbench& bench) {
  if (!bench.scene()) return;
  const SceneDescription& outline = bench.scene()->outline;
  choose_variant(bench);
  list_materials(bench);
  const int index = bench.selected_material();
  if (index < 0 || size_t(index) >= outline.materials.size()) {
    widgets::quiet_paragraph("Click on the picture, or on a name, to choose a material.");
    return;
  }
  const MaterialDescription& own = outline.materials[size_t(index)];
  MaterialEdit edit = material_edit(bench.edits(), outline, index);
  widgets::heading(shown_name(own.name, "material", index).c_str());
  ImGui::PushID(index);  // which headings are open is each material's own
  bool changed = edit_factors(edit, own);
  ImGui::PopID();
  if (changes_something(edit) && ImGui::Button("Back to the file's", {-FLT_MIN, 0.0f})) {
    edit = untouched(edit.target);
    changed = true;
  }
  if (!changed) return;
  SceneEdits edits = bench.edits();
  put(edits, outline, edit);
  bench.change(edits, fmt::format("material {}", index));
}

namespace {

void choose_file_camera(Workbench& bench) {
  const auto& cameras = bench.scene()->outline.cameras;
  if (cameras.empty()) return;
  const CameraEdit& now = bench.edits().camera;
  CameraEdit edit;
  edit.camera = now.camera;
  if (choose_target({"File camera"}, edit.camera, cameras, "camera", "as opened",
                    now.look_from ? "free" : "")) {
    const auto index = edit.camera ? find_entry(*edit.camera, cameras) : std::nullopt;
    if (index && cameras[*index].fault) {
      return bench.say(Message::Level::kError, cameras[*index].fault->what());
    }
    bench.change_camera(edit, "file camera");
  }
}

void choose_projection(Workbench& bench, const CameraDescription& seen) {
  constexpr std::array kChoices = {
      widgets::Choice{"perspective", "what is farther away is smaller"},
      widgets::Choice{"orthographic", "sizes do not depend on the distance; without a lens"}};
  int index = seen.orthographic ? 1 : 0;
  if (widgets::choose_index({"Projection", "what is orbited keeps its size on a change"}, index,
                            kChoices)) {
    bench.set_orthographic(index == 1);
  }
}

void slide_fov(Workbench& bench, const CameraDescription& seen) {
  CameraEdit edit = bench.edits().camera;
  auto fov = float(seen.fov_y * 180.0 / std::numbers::pi);
  bool reset = false;
  const bool moved =
      widgets::slide({"Field of view", "vertical", edit.fov_y_degrees.has_value(), &reset}, fov,
                     1.0f, 150.0f, "%.1f°");
  if (moved) edit.fov_y_degrees = double(fov);
  if (reset) edit.fov_y_degrees.reset();
  if (moved || reset) bench.change_camera(edit, "field of view");
}

// Without "back to the file's", which has a height for some cameras only.
void slide_height(Workbench& bench, const CameraDescription& seen) {
  const auto radius = float(bench.scene()->radius);
  CameraEdit edit = bench.edits().camera;
  auto height = float(2.0 * seen.y_mag);
  if (widgets::slide({"Height", "metres from the picture's lower edge to its upper one",
                      edit.orthographic_height.has_value()},
                     height, kLeastHeight * radius, kMostHeight * radius, "%.4g m", true)) {
    edit.orthographic_height = double(height);
    bench.change_camera(edit, "height");
  }
}

void draw_lens(Workbench& bench) {
  CameraEdit edit = bench.edits().camera;
  bool lens = edit.f_stop.has_value();
  if (widgets::check({"Lens", "depth of field; else a pinhole, and all is sharp"}, lens)) {
    edit.f_stop = lens ? std::optional<double>(kFirstStop) : std::nullopt;
    edit.focus_distance = lens ? std::optional<double>(bench.focus_distance()) : std::nullopt;
    bench.change_camera(edit, "lens");
  }
  if (!edit.f_stop) return;
  auto stop = float(*edit.f_stop);
  if (widgets::slide({"Aperture", "a smaller number is a larger opening, and less is sharp"}, stop,
                     0.5f, 64.0f, "f/%.2g", true)) {
    edit.f_stop = double(stop);
    bench.change_camera(edit, "aperture");
  }
  auto focus = float(bench.focus_distance());
  const auto radius = float(bench.scene()->radius);
  if (widgets::slide({"Focus", "metres; a double click on the picture focuses there"}, focus,
                     0.01f * radius, 20.0f * radius, "%.3g m", true)) {
    edit.focus_distance = double(focus);
    bench.change_camera(edit, "focus");
  }
}

void draw_bookmarks(Workbench& bench) {
  const float spacing = 0.5f * ImGui::GetStyle().ItemInnerSpacing.x;
  const float side = (ImGui::GetContentRegionAvail().x - 8.0f * spacing) / 9.0f;
  for (int i = 1; i <= 9; ++i) {
    const bool stored = bench.bookmarks()[size_t(i - 1)].has_value();
    if (i > 1) ImGui::SameLine(0.0f, spacing);
    ImGui::PushStyleColor(ImGuiCol_Text,
                          stored ? ImGui::GetStyleColorVec4(ImGuiCol_Text) : quiet_colour());
    const bool pressed = ImGui::Button(std::to_string(i).c_str(), {side, 0.0f});
    ImGui::PopStyleColor();
    if (ImGui::IsItemHovered()) {
      widgets::help(stored ? "go there; Ctrl+click stores the view in its place"
                           : "empty; a click stores the view");
    }
    if (pressed) {
      const bool store = !stored || ImGui::GetIO().KeyCtrl;
      bench.act(store ? Action::kStoreBookmark : Action::kRecallBookmark, i);
    }
  }
}

}  // namespace

void draw_camera(Workbench& bench) {
  if (!bench.scene()) return;
  choose_file_camera(bench);
  const SceneEdits& edits = bench.edits();
  const CameraDescription seen =
      edited_camera(edits, bench.scene()->outline, bench.scene()->camera);
  choose_projection(bench, seen);
  if (seen.orthographic) {
    slide_height(bench, seen);
  } else {
    slide_fov(bench, seen);
    draw_lens(bench);
  }
  bool mirrored = seen.to_world.determinant() < 0;
  if (widgets::check({"Mirrored", "left and right exchanged"}, mirrored)) {
    bench.set_mirrored(mirrored);
  }
  const auto& m = seen.to_world;
  widgets::text({"Position"}, fmt::format("{:.4g}  {:.4g}  {:.4g}", m[3][0], m[3][1], m[3][2]));
  widgets::text({"Direction"}, fmt::format("{:.3f}  {:.3f}  {:.3f}", -m[2][0], -m[2][1], -m[2][2]));

  const float half = 0.5f * (ImGui::GetContentRegionAvail().x - ImGui::GetStyle().ItemSpacing.x);
  if (ImGui::Button("Frame all", {half, 0.0f})) bench.act(Action::kFrameAll);
  ImGui::SameLine();
  if (ImGui::Button("Reset", {half, 0.0f})) bench.act(Action::kResetCamera);
  widgets::heading("Bookmarks");
  draw_bookmarks(bench);
}

}  // namespace emberline
