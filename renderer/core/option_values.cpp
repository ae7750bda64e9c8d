#include "renderer/core/option_values.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cctype>
#include <charconv>
#include <cmath>

#include "renderer/core/names.h"
#include "renderer/core/shortened.h"

namespace emberline {
namespace {

template <typename T>
std::optional<T> parse_entire_text(std::string_view text) {
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  T value{};
  const char* const end = text.data() + text.size();
  const auto [stopped, error] = std::from_chars(text.data(), end, value);
  if (text.empty() || error != std::errc() || stopped != end) return std::nullopt;
  return value;
}

}  // namespace

std::optional<double> parse_real(std::string_view text) {
  const std::optional<double> value = parse_entire_text<double>(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

std::optional<float> parse_share(std::string_view text) {
  if (!text.ends_with('%')) return parse_number<float>(text);
  text.remove_suffix(1);
  const std::optional<double> percent = parse_real(text);
  if (!percent || !(std::abs(*percent) <= double(std::numeric_limits<float>::max()))) return {};
  return float(*percent / 100);
}

std::optional<int64_t> parse_integer(std::string_view text) {
  return parse_entire_text<int64_t>(text);
}

std::optional<uint64_t> parse_size(std::string_view text) {
  constexpr std::string_view kUnits = "KMGT";
  std::string upper(text);
  for (char& c : upper) c = char(std::toupper(static_cast<unsigned char>(c)));
  std::string_view rest = upper;
  const bool is_binary = rest.ends_with("IB"), is_decimal = !is_binary && rest.ends_with("B");
  rest.remove_suffix(is_binary ? 2 : is_decimal ? 1 : 0);
  double factor = 1.0;
  if (const size_t unit = rest.empty() ? rest.npos : kUnits.find(rest.back()); unit != rest.npos) {
    factor = std::pow(is_decimal ? 1000.0 : 1024.0, double(unit + 1));
    rest.remove_suffix(1);
  } else if (is_binary || is_decimal) {
    return std::nullopt;
  }
  const std::optional<double> number = parse_real(rest);
  if (!number || !(*number * factor >= 1.0) || !(*number * factor < 0x1p63)) return std::nullopt;
  return uint64_t(*number * factor);
}

std::string unknown_word_message(const char* kind, const std::string& word,
                                 const std::vector<std::string>& valid) {
  const std::vector<std::string_view> views(valid.begin(), valid.end());
  const std::string message = unknown_name_message(kind, word, views);
  if (views.size() <= kMaxListedNames) return message;  // the message already lists the words
  return fmt::format("{}; valid names are {}", message, fmt::join(valid, ", "));
}

std::vector<std::string_view> split_list(std::string_view text) {
  std::vector<std::string_view> parts;
  while (!text.empty()) {
    const size_t comma = std::min(text.find(','), text.size());
    if (comma > 0) parts.push_back(text.substr(0, comma));
    text.remove_prefix(std::min(text.size(), comma + 1));
  }
  return parts;
}

}  // namespace emberline
