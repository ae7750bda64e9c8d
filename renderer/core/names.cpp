#include "renderer/core/names.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "renderer/core/errors.h"
#include "renderer/core/shortened.h"

namespace emberline {

// Uses dynamic programming and keeps only one row of its table.
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

namespace {

constexpr size_t kMaxComparedLength = 64;  // only the beginning of longer names is compared

// Returns the beginning of a name, without leading dashes.
std::string_view comparable_part(std::string_view name) {
  return name.substr(std::min(name.find_first_not_of('-'), name.size()), kMaxComparedLength);
}

// Returns the length of the longest substring that both words contain.
size_t longest_common_run(std::string_view a, std::string_view b) {
  std::vector<size_t> row(b.size() + 1);
  size_t longest = 0;
  for (const char letter : a) {
    for (size_t j = b.size(); j > 0; --j) {
      row[j] = b[j - 1] == letter ? row[j - 1] + 1 : 0;
      longest = std::max(longest, row[j]);
    }
  }
  return longest;
}

// Returns a number from 0, for identical words, to 1, for words without a common letter.
double dissimilarity(std::string_view a, std::string_view b) {
  constexpr size_t kMinCommonRun = 3;  // letters; shorter runs match by chance
  const double longest = double(std::max<size_t>({a.size(), b.size(), 1}));
  const double edits = double(edit_distance(a, b));
  // If most of the shorter word occurs in the longer one, edits weigh only a third as much (a
  // factor that we chose).
  const size_t run = longest_common_run(a, b), shorter = std::min(a.size(), b.size());
  if (run >= kMinCommonRun && 4 * run >= 3 * shorter) return edits / 3 / longest;
  return edits / longest;
}

}  // namespace

std::vector<size_t> nearest_indices(std::string_view name,
                                    std::span<const std::string_view> valid) {
  constexpr size_t kMaxSuggestions = 3;
  std::vector<std::pair<double, size_t>> ranked;
  for (size_t i = 0; i < valid.size(); ++i) {
    ranked.emplace_back(dissimilarity(comparable_part(name), comparable_part(valid[i])), i);
  }
  std::ranges::sort(ranked);
  std::vector<size_t> nearest;
  for (size_t i = 0; i < std::min(kMaxSuggestions, ranked.size()); ++i)
    nearest.push_back(ranked[i].second);
  return nearest;
}

std::string nearest_names(std::string_view name, std::span<const std::string_view> valid) {
  const std::vector<size_t> nearest = nearest_indices(name, valid);
  std::string text;
  for (size_t i = 0; i < nearest.size(); ++i) {
    const char* separator = i == 0 ? "" : i + 1 < nearest.size() ? ", " : " or ";
    text += fmt::format("{}'{}'", separator, shortened(valid[nearest[i]]));
  }
  return text;
}

std::string unknown_name_message(std::string_view kind, std::string_view name,
                                 std::span<const std::string_view> valid) {
  if (valid.size() > kMaxListedNames) {
    const std::string nearest = nearest_names(name, valid);
    return fmt::format("unknown {} '{}'{}", kind, shortened(name),
                       nearest.empty() ? "" : fmt::format(" (did you mean {}?)", nearest));
  }
  std::string_view nearest;
  size_t nearest_distance = 0;
  for (const std::string_view candidate : valid) {
    if (name.size() > kMaxComparedLength) break;
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
