// One wording for every name a user may choose from a table: samplers, filters, integrators,
// drivers. Used only while options are read.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/core/errors.h"

namespace emberline {

// Number of single-character insertions, deletions and substitutions between two words
// (Levenshtein 1966), by the usual two-row dynamic program; O(|a| |b|).
inline size_t edit_distance(std::string_view a, std::string_view b) {
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

// "unknown sampler 'sobel' (did you mean 'sobol'?); valid names are sobol, independent".
// A suggestion is made when at most a third of its letters differ, so that nonsense gets none.
inline std::string unknown_name_message(std::string_view kind, std::string_view name,
                                        std::span<const std::string_view> valid) {
  std::string list;
  std::string_view nearest;
  size_t nearest_distance = 0;
  // Names are short words; a pasted paragraph is not worth a quadratic comparison.
  const bool comparable = name.size() <= 64;
  for (const std::string_view candidate : valid) {
    list += (list.empty() ? "" : ", ") + std::string(candidate);
    const size_t distance = comparable ? edit_distance(name, candidate) : candidate.size();
    if (3 * distance <= candidate.size() && (nearest.empty() || distance < nearest_distance)) {
      nearest = candidate;
      nearest_distance = distance;
    }
  }
  const std::string hint = nearest.empty() ? "" : " (did you mean '" + std::string(nearest) + "'?)";
  return "unknown " + std::string(kind) + " '" + std::string(name) + "'" + hint +
         "; valid names are " + list;
}

// The entry of `table` (entries have a `name`) called `name`. Throws UsageError, which starts with
// the option's name.
template <typename Table>
const auto& find_named(const Table& table, std::string_view option, std::string_view kind,
                       std::string_view name) {
  std::vector<std::string_view> valid;
  for (const auto& entry : table) {
    if (entry.name == name) return entry;
    valid.push_back(entry.name);
  }
  throw UsageError(std::string(option) + ": " + unknown_name_message(kind, name, valid));
}

}  // namespace emberline
