// Limits the length of texts that come from outside when they appear in messages.
#pragma once

#include <string>
#include <string_view>

namespace emberline {

// Truncates a long text for quoting it in a message.
inline std::string shortened(std::string_view text) {
  constexpr size_t kMaxLength = 80;
  std::string cut(text.substr(0, kMaxLength));
  if (cut.size() < text.size()) cut += "...";
  return cut;
}

// Cuts the middle out of an overlong message, since the beginning says where the error is, and the
// end says what to do.
inline std::string truncate_middle(std::string_view message) {
  constexpr size_t kHeadLength = 1500, kTailLength = 500;
  if (message.size() <= kHeadLength + kTailLength) return std::string(message);
  std::string cut(message.substr(0, kHeadLength));
  return (cut += "...").append(message.substr(message.size() - kTailLength));
}

}  // namespace emberline
