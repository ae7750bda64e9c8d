// Options that are numbers. Apart from option_values.h, since CLI11 takes long to compile.
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <type_traits>

#include "renderer/core/option_values.h"
#include "renderer/core/shortened.h"

namespace emberline {

// An option whose value is one number in [min, max]. `Target` is the number or an optional of it.
template <typename T, typename Target>
CLI::Option* add_number(CLI::App* app, const std::string& name, Target& target, T min, T max,
                        const std::string& help) {
  const std::string range = fmt::format("{} to {}", min, max);
  return app
      ->add_option_function<std::string>(
          name,
          [&target, name, min, max, range](const std::string& text) {
            const std::optional<T> value = parse_number<T>(text);
            if (!value || *value < min || *value > max) {
              throw CLI::ValidationError(
                  name, fmt::format("'{}' is not a {} from {}", shortened(text),
                                    std::is_integral_v<T> ? "whole number" : "number", range));
            }
            target = *value;
          },
          help)
      ->type_name(fmt::format("{}..{}", min, max));
}

}  // namespace emberline
