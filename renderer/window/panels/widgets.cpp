#include "renderer/window/panels/widgets.h"

#include <imgui.h>

#include <algorithm>

#include "renderer/window/panels/theme.h"

namespace emberline::widgets {
namespace {

constexpr float kNameWidth = 0.36f;  // relative to the panel

// Draws the name, moves the cursor to the widget, and returns the widget's label.
std::string begin(const Row& row) {
  const float left = ImGui::GetCursorPosX();
  ImGui::AlignTextToFramePadding();
  if (row.edited) {
    ImGui::TextColored(accent_colour(), "%s", row.name);
  } else {
    ImGui::TextUnformatted(row.name);
  }
  if (row.help) help(row.help);
  if (row.edited && row.reset) {
    help("changed; a right click brings back the file's value");
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
  help("Ctrl+click to type a number");
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

bool choose_index(const Row& row, int& index, std::span<const Choice> choices,
                  const std::string& otherwise, const char* empty_means) {
  const std::string label = begin(row);
  const bool listed = index >= 0 && size_t(index) < choices.size();
  const bool empty = !listed && otherwise.empty();
  std::string shown = otherwise;
  if (listed) shown = choices[size_t(index)].name;
  if (empty && empty_means) shown = empty_means;
  if (!ImGui::BeginCombo(label.c_str(), shown.c_str(), ImGuiComboFlags_HeightLarge)) return false;
  bool changed = false;
  const auto offer = [&](std::string_view name, int i, bool chosen) {
    ImGui::PushID(i);  // names may be equal
    if (ImGui::Selectable(std::string(name).c_str(), chosen)) {
      index = i;
      changed = true;
    }
    ImGui::PopID();
  };
  if (empty_means) offer(empty_means, -1, empty);
  const int before = index;
  for (int i = 0; i < int(choices.size()); ++i) {
    const Choice& choice = choices[size_t(i)];
    offer(choice.name, i, i == before);
    if (!choice.summary.empty()) help(std::string(choice.summary));
    if (i == before) ImGui::SetItemDefaultFocus();
  }
  ImGui::EndCombo();
  return changed;
}

bool choose(const Row& row, std::string& value, std::span<const Choice> choices,
            const char* empty_means) {
  const auto found = std::ranges::find(choices, value, &Choice::name);
  int index = found == choices.end() ? -1 : int(found - choices.begin());
  if (!choose_index(row, index, choices, value, empty_means)) return false;
  value = index < 0 ? "" : choices[size_t(index)].name;
  return true;
}

std::vector<Choice> choices_of_names(std::span<const std::string> names) {
  std::vector<Choice> choices;
  for (const std::string& name : names) choices.push_back({name, ""});
  return choices;
}

float half_width() {
  return 0.5f * (ImGui::GetContentRegionAvail().x - ImGui::GetStyle().ItemSpacing.x);
}

void heading(const char* text) {
  ImGui::Dummy({0.0f, 0.2f * ImGui::GetFontSize()});
  ImGui::TextColored(quiet_colour(), "%s", text);
  ImGui::Separator();
}

void help(const std::string& text) {
  if (ImGui::IsItemHovered()) tooltip(text);
}

void tooltip(const std::string& text) {
  ImGui::BeginTooltip();
  ImGui::PushTextWrapPos(24.0f * ImGui::GetFontSize());
  ImGui::TextUnformatted(text.c_str());
  ImGui::PopTextWrapPos();
  ImGui::EndTooltip();
}

void quiet_paragraph(const std::string& text) {
  ImGui::PushStyleColor(ImGuiCol_Text, quiet_colour());
  paragraph(text);
  ImGui::PopStyleColor();
}

void paragraph(const std::string& text) {
  ImGui::PushTextWrapPos(0.0f);
  ImGui::TextUnformatted(text.c_str());
  ImGui::PopTextWrapPos();
}

}  // namespace emberline::widgets
