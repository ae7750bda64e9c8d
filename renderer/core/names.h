// Looks up the names of table entries that users choose (samplers, filters, integrators, drivers),
// with the same error messages for all tables. Used only while options are read.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace emberline {

// A row of a table that maps names to values.
template <typename T>
struct NamedValue {
  std::string_view name;
  std::string_view summary;
  T value;
};

// Returns the name of a value, or an empty text if the table does not contain the value.
template <typename T>
std::string_view name_of(std::span<const NamedValue<T>> table, T value) {
  for (const NamedValue<T>& entry : table) {
    if (entry.value == value) return entry.name;
  }
  return {};
}

// Returns the smallest number of single-character insertions, deletions and substitutions that turn
// one word into the other (Levenshtein 1966). Takes O(|a| |b|) time.
size_t edit_distance(std::string_view a, std::string_view b);

// If there are more valid names than this, messages list only the nearest names instead of all.
inline constexpr size_t kMaxListedNames = 12;

// Returns the indices in `valid` of the three names that are most similar to `name`, nearest first.
// Two names also count as similar if one contains most of the other.
std::vector<size_t> nearest_indices(std::string_view name, std::span<const std::string_view> valid);
// Returns the nearest names as text, such as "'spp', 'min-spp' or 'max-spp'". The text is empty if
// `valid` is empty.
std::string nearest_names(std::string_view name, std::span<const std::string_view> valid);

// Returns a message such as "unknown sampler 'sobel' (did you mean 'sobol'?); valid names are
// sobol, independent". A name is suggested only if the number of edits is at most a third of the
// name's length. With more than kMaxListedNames names, the message suggests the three nearest names
// instead of listing all: "unknown setting 'sp' (did you mean 'spp', 'min-spp' or 'max-spp'?)".
std::string unknown_name_message(std::string_view kind, std::string_view name,
                                 std::span<const std::string_view> valid);

// Throws UsageError with the option's name and unknown_name_message().
[[noreturn]] void throw_unknown_name(std::string_view option, std::string_view kind,
                                     std::string_view name,
                                     std::span<const std::string_view> valid);

// Returns the entry of `table` with this `name`. Throws UsageError like throw_unknown_name().
template <typename Table>
const auto& find_named(const Table& table, std::string_view option, std::string_view kind,
                       std::string_view name) {
  std::vector<std::string_view> valid;
  for (const auto& entry : table) {
    if (entry.name == name) return entry;
    valid.push_back(entry.name);
  }
  throw_unknown_name(option, kind, name, valid);
}

}  // namespace emberline
