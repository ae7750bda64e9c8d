// Limits the length of texts from outside in messages.
#pragma once

#include <string>
#include <string_view>

namespace emberline {

// Cuts a text for use within a message.
inline std::string shortened(std::string_view text) {
  constexpr size_t kLongest = 80;
  std::string cut(text.substr(0, kLongest));
  if (cut.size() < text.size()) cut += "...";
  return cut;
}

// Cuts an overlong message in the middle: its beginning says where, its end what to do.
inline std::string fitting(std::string_view message) {
  constexpr size_t kBeginning = 1500, kEnd = 500;
  if (message.size() <= kBeginning + kEnd) return std::string(message);
  std::string cut(message.substr(0, kBeginning));
  return (cut += "...").append(message.substr(message.size() - kEnd));
}

}  // namespace emberline
