// An option of a benchmark whose value is a number in [min, max].
#pragma once

#include <CLI/CLI.hpp>

namespace emberline::bench {

// `Target` is the number or an optional of it.
template <typename T, typename Target>
void add_number(CLI::App* app, const char* name, Target& target, T min, T max, const char* help) {
  app->add_option(name, target, help)->check(CLI::Range(min, max));
}

}  // namespace emberline::bench
