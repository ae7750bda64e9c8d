#include "renderer/window/panels/label.h"

#include <algorithm>
#include <array>
#include <cctype>

namespace emberline {
namespace {

constexpr std::array<std::string_view, 2> kAcronyms = {"id", "uv"};

char upper(char c) { return char(std::toupper(static_cast<unsigned char>(c))); }

std::string capitalized(std::string_view word) {
  std::string text(word);
  if (std::ranges::find(kAcronyms, word) != kAcronyms.end()) {
    std::ranges::transform(text, text.begin(), upper);
  } else if (!text.empty()) {
    text[0] = upper(text[0]);
  }
  return text;
}

}  // namespace

std::string title_case(std::string_view name) {
  std::string text;
  while (true) {
    const size_t end = std::min(name.find_first_of(" _-"), name.size());
    text += capitalized(name.substr(0, end));
    if (end == name.size()) return text;
    text += name[end] == '_' ? ' ' : name[end];
    name.remove_prefix(end + 1);
  }
}

std::string sentence_case(std::string_view text) {
  std::string sentence(text);
  if (!sentence.empty()) sentence[0] = upper(sentence[0]);
  return sentence;
}

}  // namespace emberline
