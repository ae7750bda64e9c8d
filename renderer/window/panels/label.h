// Texts of labels and tooltips, without ImGui.
#pragma once

#include <string>
#include <string_view>

namespace emberline {

// The text of a tooltip: a literal that begins with a capital. One sentence has no full stop, two
// have both. A missing or empty text does not compile, so that every control has a tooltip.
class Help {
 public:
  consteval Help(const char* text) : text_(text) {
    if (text == nullptr || *text == '\0') throw "a control needs a tooltip";
  }
  constexpr const char* text() const { return text_; }

 private:
  const char* text_;
};

// The label of a command-line value: "blue_noise" becomes "Blue Noise", "two-stream" "Two-Stream".
std::string title_case(std::string_view name);
// The text with a capital at its beginning.
std::string sentence_case(std::string_view text);

}  // namespace emberline
