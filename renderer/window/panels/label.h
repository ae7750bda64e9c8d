// Texts of labels and tooltips, without ImGui.
#pragma once

#include <string>
#include <string_view>

namespace emberline {

// The text of a tooltip: a literal that begins with a capital letter. If the text is a single
// sentence, it has no full stop; otherwise every sentence has one. A missing or empty text does not
// compile, so that every control has a tooltip.
class Help {
 public:
  consteval Help(const char* text) : text_(text) {
    if (text == nullptr || *text == '\0') throw "a control needs a tooltip";
  }
  constexpr const char* text() const { return text_; }

 private:
  const char* text_;
};

// Returns the label for a value on the command line: "Blue Noise" for "blue_noise", "Two-Stream"
// for "two-stream".
std::string title_case(std::string_view name);
// Returns the text with its first letter capitalised.
std::string sentence_case(std::string_view text);

}  // namespace emberline
