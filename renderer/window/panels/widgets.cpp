#include "renderer/window/panels/widgets.h"

#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>

#include "renderer/window/panels/theme.h"
#include "renderer/window/workbench/clock.h"

namespace emberline::widgets {
namespace {

constexpr float kNameWidth = 0.4f;       // relative to the panel's width
constexpr double kTooltipDelay_s = 0.5;  // time for which the mouse must rest on an item
constexpr double kNever_s = 1e300;
constexpr const char* kTypeNumber = "Ctrl+click to type a number.";

// The item under the mouse. A global variable is enough: there is one window, with one thread.
struct Hovered {
  ImVec2 at{-1.0f, -1.0f};
  int frame = -2;
  double since_s = 0.0;
  bool is_waiting = false;  // the tooltip will be shown if the mouse stays
};
Hovered hovered;

// Returns whether the mouse has rested long enough on the item drawn last.
bool is_tooltip_due() {
  if (!ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled) || ImGui::IsItemActive()) {
    return false;
  }
  const ImVec2 at = ImGui::GetItemRectMin();
  const int frame = ImGui::GetFrameCount();
  const double now = window_time_s();
  if (at.x != hovered.at.x || at.y != hovered.at.y || frame > hovered.frame + 1) {
    hovered.since_s = now;
  }
  hovered.at = at;
  hovered.frame = frame;
  hovered.is_waiting = now < hovered.since_s + kTooltipDelay_s;
  return !hovered.is_waiting;
}

std::string with_hint(Help help, const char* hint) {
  const std::string text = help.text();
  return text + (text.ends_with('.') ? " " : ". ") + hint;
}

// Draws the row's name, moves ImGui's cursor to where the widget begins, and returns the widget's
// label.
std::string begin(const Row& row) {
  const float left = ImGui::GetCursorPosX();
  const float row_width = ImGui::GetContentRegionAvail().x;
  ImGui::AlignTextToFramePadding();
  if (row.edited) {
    ImGui::TextColored(accent_colour(), "%s", row.name);
  } else {
    ImGui::TextUnformatted(row.name);
  }
  const float name = ImGui::GetItemRectSize().x + ImGui::GetStyle().ItemInnerSpacing.x;
  const bool can_reset = row.edited && row.reset;
  if (can_reset && ImGui::IsItemClicked(ImGuiMouseButton_Right)) *row.reset = true;
  help(can_reset ? with_hint(row.help, "Right-click to reset.") : row.help.text());
  ImGui::SameLine();
  ImGui::SetCursorPosX(left + std::max(kNameWidth * row_width, name));
  ImGui::SetNextItemWidth(-FLT_MIN);
  return std::string("##") + row.name;
}

ImGuiSliderFlags slider_flags(bool logarithmic) {
  const ImGuiSliderFlags flags = ImGuiSliderFlags_AlwaysClamp;
  return logarithmic ? flags | ImGuiSliderFlags_Logarithmic : flags;
}

}  // namespace

bool slide(const Row& row, float& value, float minimum, float maximum, const char* format,
           bool logarithmic) {
  const std::string label = begin(row);
  const bool changed = ImGui::SliderFloat(label.c_str(), &value, minimum, maximum, format,
                                          slider_flags(logarithmic));
  help(with_hint(row.help, kTypeNumber));
  return changed;
}

bool slide(const Row& row, int& value, int minimum, int maximum, bool logarithmic) {
  const std::string label = begin(row);
  const bool changed =
      ImGui::SliderInt(label.c_str(), &value, minimum, maximum, "%d", slider_flags(logarithmic));
  help(with_hint(row.help, kTypeNumber));
  return changed;
}

bool colour(const Row& row, Rgb& value, bool hdr) {
  const std::string label = begin(row);
  ImGuiColorEditFlags flags = ImGuiColorEditFlags_Float | ImGuiColorEditFlags_PickerHueWheel |
                              ImGuiColorEditFlags_NoTooltip;
  if (hdr) flags |= ImGuiColorEditFlags_HDR;
  const bool changed = ImGui::ColorEdit3(label.c_str(), &value.x, flags);
  help(row.help);
  return changed;
}

bool check(const Row& row, bool& value) {
  const std::string label = begin(row);
  const bool changed = ImGui::Checkbox(label.c_str(), &value);
  help(row.help);
  return changed;
}

void text(const Row& row, const std::string& value) {
  begin(row);
  ImGui::TextUnformatted(value.c_str());
  help(row.help);
}

bool choose_index(const Row& row, int& index, std::span<const Choice> choices,
                  const std::string& placeholder, const char* none_label) {
  const std::string label = begin(row);
  const bool listed = index >= 0 && size_t(index) < choices.size();
  const bool empty = !listed && placeholder.empty();
  std::string preview = placeholder;
  if (listed) preview = choices[size_t(index)].label;
  if (empty && none_label) preview = none_label;
  if (!begin_list(label.c_str(), row.help, preview)) return false;
  bool changed = false;
  const auto offer = [&](const std::string& name, int i, bool chosen) {
    ImGui::PushID(i);  // because two names may be the same
    if (ImGui::Selectable(name.c_str(), chosen)) {
      index = i;
      changed = true;
    }
    ImGui::PopID();
  };
  if (none_label) offer(none_label, -1, empty);
  const int before = index;
  for (int i = 0; i < int(choices.size()); ++i) {
    const Choice& choice = choices[size_t(i)];
    offer(choice.label, i, i == before);
    if (!choice.summary.empty()) help(choice.summary);
    if (i == before) ImGui::SetItemDefaultFocus();
  }
  ImGui::EndCombo();
  return changed;
}

bool choose(const Row& row, std::string& value, std::span<const Choice> choices,
            const char* none_label) {
  const auto found = std::ranges::find(choices, value, &Choice::name);
  int index = found == choices.end() ? -1 : int(found - choices.begin());
  if (!choose_index(row, index, choices, value, none_label)) return false;
  value = index < 0 ? "" : choices[size_t(index)].name;
  return true;
}

std::vector<Choice> choices_of_names(std::span<const std::string> names) {
  std::vector<Choice> choices;
  for (const std::string& name : names) choices.push_back({name, name, ""});
  return choices;
}

bool button(const char* label, Help text, float width) {
  const bool pressed = ImGui::Button(label, {width < 0.0f ? -FLT_MIN : width, 0.0f});
  help(text);
  return pressed;
}

bool small_button(const char* label, Help text) {
  const bool pressed = ImGui::SmallButton(label);
  help(text);
  return pressed;
}

bool checkbox(const char* label, Help text, bool& value) {
  const bool changed = ImGui::Checkbox(label, &value);
  help(text);
  return changed;
}

bool menu_flag(const char* label, Help text, bool& value) {
  const bool changed = ImGui::MenuItem(label, "", &value);
  help(text);
  return changed;
}

bool swatch(const char* id, Help text, Rgb& value) {
  const bool changed = ImGui::ColorEdit3(
      id, &value.x,
      ImGuiColorEditFlags_NoInputs | ImGuiColorEditFlags_NoLabel | ImGuiColorEditFlags_Float |
          ImGuiColorEditFlags_PickerHueWheel | ImGuiColorEditFlags_NoTooltip);
  help(text);
  return changed;
}

bool slide_bare(const char* id, Help text, float& value, float minimum, float maximum,
                const char* format) {
  const bool changed =
      ImGui::SliderFloat(id, &value, minimum, maximum, format, ImGuiSliderFlags_Logarithmic);
  help(with_hint(text, kTypeNumber));
  return changed;
}

bool slide_bare(const char* id, Help text, double& value, double maximum, const char* preview) {
  const double minimum = 0.0;
  const bool changed =
      ImGui::SliderScalar(id, ImGuiDataType_Double, &value, &minimum, &maximum, preview,
                          ImGuiSliderFlags_AlwaysClamp | ImGuiSliderFlags_NoInput);
  help(text);
  return changed;
}

bool drag_bare(const char* id, Help text, double& value, double step, double minimum,
               double maximum, const char* format) {
  const bool changed = ImGui::DragScalar(id, ImGuiDataType_Double, &value, float(step), &minimum,
                                         &maximum, format, ImGuiSliderFlags_AlwaysClamp);
  help(with_hint(text, kTypeNumber));
  return changed;
}

bool drag_pair(const char* id, Help text, float (&values)[2], float step, float minimum,
               float maximum, const char* format) {
  const bool changed =
      ImGui::DragFloat2(id, values, step, minimum, maximum, format, ImGuiSliderFlags_AlwaysClamp);
  help(with_hint(text, kTypeNumber));
  return changed;
}

bool input_line(const char* id, Help text, std::string& value) {
  const bool entered = ImGui::InputText(id, &value, ImGuiInputTextFlags_EnterReturnsTrue);
  help(text);
  return entered;
}

bool begin_list(const char* id, Help text, const std::string& preview) {
  const bool open = ImGui::BeginCombo(id, preview.c_str(), ImGuiComboFlags_HeightLarge);
  if (!open) help(text);
  return open;
}

float half_width() {
  return 0.5f * (ImGui::GetContentRegionAvail().x - ImGui::GetStyle().ItemSpacing.x);
}

void heading(const char* text) {
  ImGui::Dummy({0.0f, 0.2f * ImGui::GetFontSize()});
  ImGui::TextColored(muted_colour(), "%s", text);
  ImGui::Separator();
}

void help(const std::string& text) {
  if (is_tooltip_due()) tooltip(text);
}

void help(Help text) { help(std::string(text.text())); }

double next_tooltip_s() {
  const bool is_waiting = hovered.is_waiting && hovered.frame == ImGui::GetFrameCount();
  return is_waiting ? hovered.since_s + kTooltipDelay_s : kNever_s;
}

void tooltip(const std::string& text) {
  ImGui::PushStyleVar(ImGuiStyleVar_Alpha, 1.0f);  // opaque, even if the control is disabled
  ImGui::BeginTooltip();
  ImGui::PushTextWrapPos(24.0f * ImGui::GetFontSize());
  ImGui::TextUnformatted(text.c_str());
  ImGui::PopTextWrapPos();
  ImGui::EndTooltip();
  ImGui::PopStyleVar();
}

void muted_paragraph(const std::string& text) {
  ImGui::PushStyleColor(ImGuiCol_Text, muted_colour());
  paragraph(text);
  ImGui::PopStyleColor();
}

void paragraph(const std::string& text) {
  ImGui::PushTextWrapPos(0.0f);
  ImGui::TextUnformatted(text.c_str());
  ImGui::PopTextWrapPos();
}

}  // namespace emberline::widgets
