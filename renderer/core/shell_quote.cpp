#include "renderer/core/shell_quote.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "renderer/core/utf8.h"

namespace emberline {
namespace {

bool is_printable(std::string_view text) {
  while (!text.empty()) {
    const size_t length = utf8_length(text);
    if (length == 0 || is_control(text.substr(0, length))) return false;
    text.remove_prefix(length);
  }
  return true;
}

bool is_shell_safe(unsigned char c) {
  return std::isalnum(c) || c >= 0x80 ||
         std::string_view("-_=+,./:@%").find(char(c)) != std::string_view::npos;
}

// "$(...)" drops trailing newlines, so each of them is appended as ${IFS#??}, the last character of
// $IFS, which every shell initialises to space, tab and newline.
std::string quoted_bytes(std::string_view argument) {
  size_t newlines = 0;
  while (argument.ends_with('\n')) {
    argument.remove_suffix(1);
    ++newlines;
  }
  std::string text = "\"$(printf '";
  for (const char c : argument) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalnum(byte) || c == ' ' || c == '.' || c == '/' || c == '_') {
      text += c;
    } else {
      text += fmt::format("\\{:03o}", byte);
    }
  }
  text += "')";
  for (; newlines > 0; --newlines) text += "${IFS#??}";
  return text + '"';
}

}  // namespace

std::string shell_quoted(std::string_view argument) {
  if (!is_printable(argument)) return quoted_bytes(argument);
  if (!argument.empty() && std::ranges::all_of(argument, is_shell_safe)) {
    return std::string(argument);
  }
  std::string text = "'";
  for (const char c : argument) text += c == '\'' ? "'\\''" : std::string(1, c);
  return text + '\'';
}

std::string shell_command(int argc, const char* const* argv) {
  std::string text = "emberline";
  for (int i = 1; i < argc; ++i) {
    text += ' ';
    text += shell_quoted(argv[i]);
  }
  return text;
}

}  // namespace emberline
