// Panel rows: the name of a value on the left, its widget on the right, as wide as the panel. All
// return whether the value was changed.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/core/vector.h"

namespace emberline::widgets {

// `edited`: the value differs from the file's; its name then has the accent colour, and a right
// click on it sets *reset.
struct Row {
  const char* name;
  const char* help = nullptr;  // tooltip of the name
  bool edited = false;
  bool* reset = nullptr;
};

bool slide(const Row& row, float& value, float least, float most, const char* format,
           bool logarithmic = false);
bool slide(const Row& row, int& value, int least, int most, bool logarithmic = false);
// A slider for a number of the file, `own`, that an edit may replace.
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

// A named choice.
struct Choice {
  std::string_view name, summary;
};
// Chooses by index. If the index is not valid, shows `otherwise` or, if that is empty,
// `empty_means`. If given, `empty_means` can be chosen as index -1.
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
// The result refers to `names`.
std::vector<Choice> choices_of_names(std::span<const std::string> names);

// Width of each of two widgets side by side; call at the beginning of their line.
float half_width();

void heading(const char* text);
// Tooltip for the previous item.
void help(const std::string& text);
void tooltip(const std::string& text);
// A paragraph wrapped at the panel's edge; quiet_paragraph() is for less important text.
void paragraph(const std::string& text);
void quiet_paragraph(const std::string& text);

}  // namespace emberline::widgets
