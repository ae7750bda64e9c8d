// Reports CLI11's errors in Emberline's wording.
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace emberline {

// Throws a UsageError whose message, a single line, names the option and says what is valid. `root`
// is the app that parsed the command line.
[[noreturn]] void throw_usage(const CLI::App& root, const CLI::ParseError& error);

// Throws UsageError for the unknown option `word`, and suggests the closest of the `valid` options.
[[noreturn]] void throw_unknown_option(const std::string& word,
                                       const std::vector<std::string>& valid,
                                       const std::string& command);

}  // namespace emberline
