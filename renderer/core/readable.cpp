#include "renderer/core/readable.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>

namespace emberline {

std::string readable_count(uint64_t count) { return with_separators(std::to_string(count)); }

std::string with_separators(std::string number) {
  const size_t first = number.starts_with('-') ? 1 : 0;
  size_t i = std::min(number.find('.'), number.size());
  for (; i > first + 3; i -= 3) number.insert(i - 3, 1, ',');
  return number;
}

std::string readable_number(double value, int digits) {
  if (std::isnan(value)) return "none";
  if (std::isinf(value)) return value > 0 ? "infinite" : "-infinite";
  // Numbers below 1e9 with more integer digits than `digits` keep them all instead of getting an
  // exponent: 12345 to three digits is 12345.
  const double size = std::abs(value);
  if (size >= std::pow(10.0, digits) - 0.5 && size < 1e9) {
    return with_separators(fmt::format("{:.0f}", value));
  }
  const std::string text = fmt::format("{:.{}g}", value, digits);
  return text.find('e') == std::string::npos ? with_separators(text) : text;
}

std::string readable_bytes(uint64_t bytes) {
  if (bytes < 1024) return fmt::format("{} B", bytes);
  double amount = double(bytes);
  const char* unit = "";
  for (const char* larger : {"KiB", "MiB", "GiB", "TiB"}) {
    if (amount < 1000) break;
    amount /= 1024;
    unit = larger;
  }
  return fmt::format("{} {}", readable_number(amount), unit);
}

std::string readable_seconds(double seconds) {
  if (!std::isfinite(seconds) || seconds < 0) return readable_number(seconds);
  if (seconds == 0) return "0 s";
  if (seconds < 0.9995e-3) return fmt::format("{} us", readable_number(1e6 * seconds));
  if (seconds < 0.9995) return fmt::format("{} ms", readable_number(1e3 * seconds));
  if (seconds < 59.95) return fmt::format("{} s", readable_number(seconds));
  const auto whole = int64_t(std::llround(seconds));
  if (whole < 3600) return fmt::format("{} min {} s", whole / 60, whole % 60);
  return fmt::format("{} h {:02} min", whole / 3600, whole / 60 % 60);
}

std::string readable_percent(double share) {
  if (share > 0 && share < 0.5e-4) return "below 0.01 %";
  return fmt::format("{} %", readable_number(100 * share));
}

std::string readable_local_time() {
  const std::time_t now = std::time(nullptr);
  std::tm parts = {};
  localtime_r(&now, &parts);
  char text[64];
  return {text, std::strftime(text, sizeof text, "%Y-%m-%d %H:%M %z", &parts)};
}

}  // namespace emberline
