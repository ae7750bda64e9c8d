// Foreign texts in messages.
#pragma once

#include <string>
#include <string_view>

namespace emberline {

// Cut to a length that fits a message.
inline std::string shortened(std::string_view text) {
  constexpr size_t kLongest = 80;
  if (text.size() <= kLongest) return std::string(text);
  return std::string(text.substr(0, kLongest)) + "...";
}

}  // namespace emberline
