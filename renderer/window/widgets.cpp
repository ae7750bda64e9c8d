#include "renderer/window/widgets.h"

#include <imgui.h>

#include <algorithm>

#include "renderer/window/theme.h"

namespace emberline::widgets {
namespace {

constexpr float kNameWidth = 0.36f;  // of the panel

// Draws the name, leaves the cursor where the widget begins, and returns the widget's label.
std::string begin(const Row& row) {
  const float left = ImGui::GetCursorPosX();
  ImGui::AlignTextToFramePadding();
  if (row.edited) {
    ImGui::TextColored(accent_colour(), "%s", row.name);
  } else {
    ImGui::TextUnformatted(row.name);
  }
  if (row.help && ImGui::IsItemHovered()) help(row.help);
  if (row.edited && row.reset) {
    if (ImGui::IsItemHovered()) help("changed; a right click brings back the file's value");
    if (ImGui::IsItemClicked(ImGuiMouseButton_Right)) *row.reset = true;
  }
  const float room = ImGui::GetContentRegionAvail().x;
  ImGui::SameLine();
  ImGui::SetCursorPosX(left + kNameWidth * room);
  ImGui::SetNextItemWidth(-FLT_MIN);
  return std::string("##") + row.name;
}

ImGuiSliderFlags slider_flags(bool logarithmic) {
  const ImGuiSliderFlags flags = ImGuiSliderFlags_AlwaysClamp;
  return logarithmic ? flags | ImGuiSliderFlags_Logarithmic : flags;
}

}  // namespace

bool slide(const Row& row, float& value, float least, float most, const char* format,
           bool logarithmic) {
  const std::string label = begin(row);
  const bool changed =
      ImGui::SliderFloat(label.c_str(), &value, least, most, format, slider_flags(logarithmic));
  if (ImGui::IsItemHovered()) help("Ctrl+click to type a number");
  return changed;
}

bool slide(const Row& row, int& value, int least, int most, bool logarithmic) {
  const std::string label = begin(row);
  return ImGui::SliderInt(label.c_str(), &value, least, most, "%d", slider_flags(logarithmic));
}

bool colour(const Row& row, Rgb& value, bool hdr) {
  const std::string label = begin(row);
  ImGuiColorEditFlags flags = ImGuiColorEditFlags_Float | ImGuiColorEditFlags_PickerHueWheel;
  if (hdr) flags |= ImGuiColorEditFlags_HDR;
  return ImGui::ColorEdit3(label.c_str(), &value.x, flags);
}

bool check(const Row& row, bool& value) {
  const std::string label = begin(row);
  return ImGui::Checkbox(label.c_str(), &value);
}

void text(const Row& row, const std::string& value) {
  begin(row);
  ImGui::TextUnformatted(value.c_str());
}

bool choose(const Row& row, std::string& value, std::span<const Choice> choices,
            const char* empty_means) {
  const std::string label = begin(row);
  const std::string shown = value.empty() && empty_means ? empty_means : value;
  if (!ImGui::BeginCombo(label.c_str(), shown.c_str(), ImGuiComboFlags_HeightLarge)) return false;
  bool changed = false;
  if (empty_means && ImGui::Selectable(empty_means, value.empty())) {
    value.clear();
    changed = true;
  }
  for (const Choice& choice : choices) {
    const std::string name(choice.name);
    const bool chosen = name == value;
    if (ImGui::Selectable(name.c_str(), chosen)) {
      value = name;
      changed = true;
    }
    if (!choice.summary.empty() && ImGui::IsItemHovered()) help(std::string(choice.summary));
    if (chosen) ImGui::SetItemDefaultFocus();
  }
  ImGui::EndCombo();
  return changed;
}

void heading(const char* text) {
  ImGui::Dummy({0.0f, 0.2f * ImGui::GetFontSize()});
  ImGui::TextColored(quiet_colour(), "%s", text);
  ImGui::Separator();
}

void help(const std::string& text) {
  ImGui::BeginTooltip();
  ImGui::PushTextWrapPos(24.0f * ImGui::GetFontSize());
  ImGui::TextUnformatted(text.c_str());
  ImGui::PopTextWrapPos();
  ImGui::EndTooltip();
}

void paragraph(const std::string& text) {
  ImGui::PushTextWrapPos(0.0f);
  ImGui::TextUnformatted(text.c_str());
  ImGui::PopTextWrapPos();
}

}  // namespace emberline::widgets
