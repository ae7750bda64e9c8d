// Formats numbers for people, independently of the locale.
#pragma once

#include <cstdint>
#include <string>

namespace emberline {

// Formats an integer, such as "14,745,600".
std::string readable_count(uint64_t count);

// Adds commas between the thousands of a plain decimal number: "-14,745,600.25".
std::string with_separators(std::string number);

// Formats a number with `digits` significant digits (1 to 15), without trailing zeros: "0.0312",
// "1,234", "1.5e-07". Returns "none" for NaN and "infinite" for infinity.
std::string readable_number(double value, int digits = 3);

// Formats a size, such as "640 B" or "12.3 MiB".
std::string readable_bytes(uint64_t bytes);

// Formats a duration, such as "820 us", "59.3 ms", "12.3 s", "3 min 20 s" or "2 h 05 min".
std::string readable_seconds(double seconds);

// Formats a fraction in [0, 1] as a percentage, such as "25.3 %".
std::string readable_percent(double share);

// Returns the time now, such as "2026-11-28 14:05 +0100".
std::string readable_local_time();

}  // namespace emberline
