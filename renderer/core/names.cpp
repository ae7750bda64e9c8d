#include "renderer/core/names.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "renderer/core/errors.h"
#include "renderer/core/shortened.h"

namespace emberline {

// Dynamic programming that keeps one row of the table.
size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<size_t> row(b.size() + 1);
  for (size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (size_t i = 0; i < a.size(); ++i) {
    size_t diagonal = row[0];
    row[0] = i + 1;
    for (size_t j = 0; j < b.size(); ++j) {
      const size_t substituted = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({substituted, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row[b.size()];
}

std::string unknown_name_message(std::string_view kind, std::string_view name,
                                 std::span<const std::string_view> valid) {
  constexpr size_t kLongestWord = 64;  // longer names are not compared
  std::string_view nearest;
  size_t nearest_distance = 0;
  for (const std::string_view candidate : valid) {
    if (name.size() > kLongestWord) break;
    const size_t distance = edit_distance(name, candidate);
    if (3 * distance <= candidate.size() && (nearest.empty() || distance < nearest_distance)) {
      nearest = candidate;
      nearest_distance = distance;
    }
  }
  const std::string hint = nearest.empty() ? "" : fmt::format(" (did you mean '{}'?)", nearest);
  return fmt::format("unknown {} '{}'{}; valid names are {}", kind, shortened(name), hint,
                     fmt::join(valid, ", "));
}

void throw_unknown_name(std::string_view option, std::string_view kind, std::string_view name,
                        std::span<const std::string_view> valid) {
  throw UsageError(std::string(option) + ": " + unknown_name_message(kind, name, valid));
}

}  // namespace emberline
