// Parses option values strictly: the whole text must be a value, and numbers must be finite and in
// range. Also composes the common error messages. CLI11's own range checks accept NaN and print
// floats with six decimals.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace emberline {

// Parses a finite decimal number in the C locale; nothing may precede or follow it.
std::optional<double> parse_real(std::string_view text);
// Parses an integer without a fraction or exponent: "64", not "64.0" or "1e3".
std::optional<int64_t> parse_integer(std::string_view text);

template <typename T>
std::optional<T> parse_number(std::string_view text) {
  if constexpr (std::is_integral_v<T>) {
    const std::optional<int64_t> value = parse_integer(text);
    if (!value || !std::in_range<T>(*value)) return std::nullopt;
    return T(*value);
  } else {
    const std::optional<double> value = parse_real(text);
    if (!value || !(std::abs(*value) <= double(std::numeric_limits<T>::max()))) return std::nullopt;
    return T(*value);
  }
}

// Parses a number or a percentage: "2%" is 0.02.
std::optional<float> parse_share(std::string_view text);

// Splits a list such as "a,b" at the commas and returns its non-empty parts, which are views into
// `text`.
std::vector<std::string_view> split_list(std::string_view text);

// Parses a list such as "1,2,3", which must consist of exactly kCount numbers.
template <typename T, size_t kCount>
bool parse_numbers(std::string_view text, char separator, std::array<T, kCount>& out) {
  for (size_t i = 0; i < kCount; ++i) {
    const size_t end = i + 1 < kCount ? text.find(separator) : text.size();
    if (end == std::string_view::npos) return false;
    const std::optional<T> value = parse_number<T>(text.substr(0, end));
    if (!value) return false;
    out[i] = *value;
    text.remove_prefix(std::min(text.size(), end + 1));
  }
  return true;
}

// Parses a size in bytes of at least 1: "4096", "1.5M", "8G". The units K, M, G, T and KiB, MiB,
// GiB, TiB are powers of 1024; KB, MB, GB, TB are powers of 1000.
std::optional<uint64_t> parse_size(std::string_view text);

// Like unknown_name_message() (names.h), but always lists every valid word.
std::string unknown_word_message(const char* kind, const std::string& word,
                                 const std::vector<std::string>& valid);

}  // namespace emberline
