// Rows of a panel: what a value is called on the left, and on the right the widget that changes it,
// as wide as the panel. All return whether the value was changed.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/core/vector.h"

namespace emberline::widgets {

// `edited`: the value is not the file's; its name is then in the accent colour, and a click on the
// name with the right button calls for the file's: Row::reset.
struct Row {
  const char* name;
  const char* help = nullptr;  // shown over the name
  bool edited = false;
  bool* reset = nullptr;
};

bool slide(const Row& row, float& value, float least, float most, const char* format,
           bool logarithmic = false);
bool slide(const Row& row, int& value, int least, int most, bool logarithmic = false);
// A number of the file, `own`, that an edit may replace.
template <typename T>
bool slide_edit(const char* name, const char* help, std::optional<T>& edit, T own, float least,
                float most, const char* format, bool logarithmic = false) {
  auto value = float(edit.value_or(own));
  bool reset = false;
  const bool moved =
      slide({name, help, edit.has_value(), &reset}, value, least, most, format, logarithmic);
  if (moved) edit = T(value);
  if (reset) edit.reset();
  return moved || reset;
}
bool colour(const Row& row, Rgb& value, bool hdr = false);
bool check(const Row& row, bool& value);
void text(const Row& row, const std::string& value);

// One of a table's names; `empty_means` is what an empty value means, and can be chosen then.
struct Choice {
  std::string_view name, summary;
};
// By the place among the choices. While it is none of theirs, `otherwise` is shown; without that
// `empty_means`, which can be chosen then and is -1.
bool choose_index(const Row& row, int& index, std::span<const Choice> choices,
                  const std::string& otherwise = {}, const char* empty_means = nullptr);
bool choose(const Row& row, std::string& value, std::span<const Choice> choices,
            const char* empty_means = nullptr);

template <typename Table>
std::vector<Choice> choices_of(const Table& table) {
  std::vector<Choice> choices;
  for (const auto& entry : table) choices.push_back({entry.name, entry.summary});
  return choices;
}
// Refer to the names.
std::vector<Choice> choices_of_names(std::span<const std::string> names);

// Width of each of two widgets side by side, at the beginning of their line.
float half_width();

// A heading between groups of rows.
void heading(const char* text);
// Help for what was drawn last, while the mouse is over it.
void help(const std::string& text);
void tooltip(const std::string& text);
// A line of text, broken where the panel ends; what matters less than the rest is quiet.
void paragraph(const std::string& text);
void quiet_paragraph(const std::string& text);

}  // namespace emberline::widgets
