// Finds a camera, variant or animation that an option selects by name or by index.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/core/errors.h"
#include "renderer/core/shortened.h"

namespace emberline {

// Parses an index, which must consist of digits only and be below `end`.
inline std::optional<size_t> parse_index(std::string_view text, size_t end) {
  size_t index = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), index);
  const bool whole = error == std::errc() && stop == text.data() + text.size();
  return whole && index < end ? std::optional(index) : std::nullopt;
}

// Lists the entries for a message, such as "0 'a', 1 'b'"; truncates a long list.
template <class Named>
std::string numbered_names(const std::vector<Named>& list) {
  constexpr size_t kMaxListed = 100;
  std::string text;
  for (size_t i = 0; i < std::min(list.size(), kMaxListed); ++i) {
    text += fmt::format("{}{} '{}'", i ? ", " : "", i, shortened(list[i].name));
  }
  return list.size() > kMaxListed ? text + " and more" : text;
}

template <class Named>
std::string list_names(const std::vector<Named>& list) {
  return list.empty() ? "the file has none" : "the file has " + numbered_names(list);
}

// Returns the index of the entry in `list` that has this name or index. If there is none, throws a
// UsageError that names the setting `what` and lists the entries.
template <class Named>
size_t find_name_or_index(const char* what, const std::string& name_or_index,
                          const std::vector<Named>& list) {
  const auto named = std::ranges::find(list, name_or_index, &Named::name);
  if (named != list.end()) return size_t(named - list.begin());
  if (const std::optional<size_t> index = parse_index(name_or_index, list.size())) return *index;
  throw UsageError(
      fmt::format("`{0}`: no {0} '{1}'; {2}", what, shortened(name_or_index), list_names(list)));
}

}  // namespace emberline
