// What an option calls by name or by index: cameras, variants, animations of a file.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <string>
#include <vector>

#include "renderer/core/errors.h"
#include "renderer/core/shortened.h"

namespace emberline {

// "0 'a', 1 'b'", for messages; of a long list its beginning.
template <class Named>
std::string numbered_names(const std::vector<Named>& list) {
  constexpr size_t kMost = 100;
  std::string text;
  for (size_t i = 0; i < std::min(list.size(), kMost); ++i) {
    text += fmt::format("{}{} '{}'", i ? ", " : "", i, shortened(list[i].name));
  }
  return list.size() > kMost ? text + " and more" : text;
}

template <class Named>
std::string list_names(const std::vector<Named>& list) {
  return list.empty() ? "the file has none" : "the file has " + numbered_names(list);
}

// The index in `list` of what --WHAT calls by name or index. Throws UsageError that lists them.
template <class Named>
size_t find_name_or_index(const char* what, const std::string& wanted,
                          const std::vector<Named>& list) {
  const auto named = std::ranges::find(list, wanted, &Named::name);
  if (named != list.end()) return size_t(named - list.begin());
  size_t index = 0;
  const auto [end, error] = std::from_chars(wanted.data(), wanted.data() + wanted.size(), index);
  if (error == std::errc() && end == wanted.data() + wanted.size() && index < list.size()) {
    return index;
  }
  throw UsageError(
      fmt::format("`{0}`: no {0} '{1}'; {2}", what, shortened(wanted), list_names(list)));
}

}  // namespace emberline
