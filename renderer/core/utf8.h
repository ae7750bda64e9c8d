// Validates and escapes UTF-8, for file names and texts that may contain arbitrary bytes.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace emberline {

// Returns the length in bytes of the well-formed UTF-8 sequence at the beginning of `text`, or 0 if
// there is none (Unicode 15, table 3-7: no overlong forms, no surrogates, nothing beyond U+10FFFF).
inline size_t utf8_length(std::string_view text) {
  const auto byte = [&](size_t i) {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u;
  };
  const auto follows = [&](size_t i, unsigned low = 0x80, unsigned high = 0xbf) {
    return byte(i) >= low && byte(i) <= high;
  };
  if (text.empty()) return 0;
  const unsigned b = byte(0);
  if (b < 0x80) return 1;
  if (b >= 0xc2 && b <= 0xdf) return follows(1) ? 2 : 0;
  if (b >= 0xe0 && b <= 0xef) {
    const bool second = follows(1, b == 0xe0 ? 0xa0 : 0x80, b == 0xed ? 0x9f : 0xbf);
    return second && follows(2) ? 3 : 0;
  }
  if (b >= 0xf0 && b <= 0xf4) {
    const bool second = follows(1, b == 0xf0 ? 0x90 : 0x80, b == 0xf4 ? 0x8f : 0xbf);
    return second && follows(2) && follows(3) ? 4 : 0;
  }
  return 0;
}

// Returns whether a well-formed UTF-8 sequence is an ASCII or C1 (U+0080 to U+009F) control
// character.
inline bool is_control(std::string_view sequence) {
  const auto c = static_cast<unsigned char>(sequence[0]);
  if (sequence.size() == 1) return c < 0x20 || c == 0x7f;
  return sequence.size() == 2 && c == 0xc2 && static_cast<unsigned char>(sequence[1]) < 0xa0;
}

// Returns `text` on one line: control characters and invalid UTF-8 become escapes such as \n, \r,
// \t or \x1b.
std::string printable(std::string_view text);

}  // namespace emberline
