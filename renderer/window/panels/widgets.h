// The controls of the panels, each with a tooltip. Panels must not call ImGui's controls directly;
// tests/view/tooltips_test.py checks that. A row is as wide as the panel, with the name of a value
// on the left and its control on the right. All controls return whether the user has changed the
// value or pressed the button.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/core/vector.h"
#include "renderer/window/panels/label.h"

namespace emberline::widgets {

// `edited` says whether the value differs from the file's. If it does, the name has the accent
// colour, and a right click on the name sets *reset, unless `reset` is null.
struct Row {
  const char* name;
  Help help;
  bool edited = false;
  bool* reset = nullptr;
};

bool slide(const Row& row, float& value, float minimum, float maximum, const char* format,
           bool logarithmic = false);
bool slide(const Row& row, int& value, int minimum, int maximum, bool logarithmic = false);
// Draws a slider for a number that an edit may replace. `own` is the file's number.
template <typename T>
bool slide_edit(const char* name, Help help, std::optional<T>& edit, T own, float minimum,
                float maximum, const char* format, bool logarithmic = false) {
  auto value = float(edit.value_or(own));
  bool reset = false;
  const bool moved =
      slide({name, help, edit.has_value(), &reset}, value, minimum, maximum, format, logarithmic);
  if (moved) edit = T(value);
  if (reset) edit.reset();
  return moved || reset;
}
bool colour(const Row& row, Rgb& value, bool hdr = false);
bool check(const Row& row, bool& value);
void text(const Row& row, const std::string& value);

// A choice in a list: its value, its label, and its tooltip, which may be empty.
struct Choice {
  std::string_view name;
  std::string label, summary;
};
// Lets the user choose an index in `choices`. If `none_label` is not null, the list also has this
// entry, which sets `index` to -1. While `index` is not valid, shows `placeholder` or, if that is
// empty, `none_label`.
bool choose_index(const Row& row, int& index, std::span<const Choice> choices,
                  const std::string& placeholder = {}, const char* none_label = nullptr);
bool choose(const Row& row, std::string& value, std::span<const Choice> choices,
            const char* none_label = nullptr);

// Returns the choices for a table whose rows have a name, as on the command line, and a summary.
template <typename Table>
std::vector<Choice> choices_of(const Table& table) {
  std::vector<Choice> choices;
  for (const auto& entry : table) {
    choices.push_back({entry.name, title_case(entry.name), sentence_case(entry.summary)});
  }
  return choices;
}
// Returns choices that show the names unchanged. The result refers to `names`, which must outlive
// it.
std::vector<Choice> choices_of_names(std::span<const std::string> names);

// Controls that are not part of a row. A `width` of 0 means the label's width; -1 means the panel's
// width.
bool button(const char* label, Help help, float width = 0.0f);
bool small_button(const char* label, Help help);
bool checkbox(const char* label, Help help, bool& value);
bool menu_flag(const char* label, Help help, bool& value);
bool swatch(const char* id, Help help, Rgb& value);
bool slide_bare(const char* id, Help help, float& value, float minimum, float maximum,
                const char* format);
bool slide_bare(const char* id, Help help, double& value, double maximum, const char* text);
bool drag_bare(const char* id, Help help, double& value, double step, double minimum,
               double maximum, const char* format);
bool drag_pair(const char* id, Help help, float (&values)[2], float step, float minimum,
               float maximum, const char* format);
bool input_line(const char* id, Help help, std::string& value);
// Opens a list for Selectable entries; end it with ImGui::EndCombo() if this returns true.
bool begin_list(const char* id, Help help, const std::string& preview);

// Returns the width of each of two widgets side by side. Call at the beginning of the line.
float half_width();

void heading(const char* text);
// Shows a tooltip for the item that was drawn last, once the mouse has rested on it for a moment.
void help(const std::string& text);
void help(Help text);
// Returns the window_time_s() at which the pending tooltip will be shown; the time is far in the
// future if no tooltip is pending.
double next_tooltip_s();
void tooltip(const std::string& text);
// Draw a paragraph that is wrapped at the panel's edge. muted_paragraph() is for less important
// text.
void paragraph(const std::string& text);
void muted_paragraph(const std::string& text);

}  // namespace emberline::widgets
