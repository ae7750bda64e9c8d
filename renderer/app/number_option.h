// Options whose texts are read as they are given. Apart from option_values.h, since CLI11 takes
// long to compile.
#pragma once

#include <fmt/format.h>

#include <functional>
#include <optional>
#include <string>
#include <type_traits>

#include "renderer/core/option_values.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace emberline {

// `read` takes the option's text, or returns false for one that is not `what`: "a number above 0".
CLI::Option* add_parsed(CLI::App* app, const std::string& name, const std::string& type,
                        const std::string& help, const std::string& what,
                        const std::function<bool(const std::string& text)>& read);

// An option whose value is one number in [min, max]. `Target` is the number or an optional of it.
template <typename T, typename Target>
CLI::Option* add_number(CLI::App* app, const std::string& name, Target& target, T min, T max,
                        const std::string& help) {
  const auto read = [&target, min, max](const std::string& text) {
    const std::optional<T> value = parse_number<T>(text);
    if (!value || *value < min || *value > max) return false;
    target = *value;
    return true;
  };
  const char* kind = std::is_integral_v<T> ? "whole number" : "number";
  return add_parsed(app, name, fmt::format("{}..{}", min, max), help,
                    fmt::format("a {} from {} to {}", kind, min, max), read);
}

}  // namespace emberline
