// What CLI11 found wrong, in our words.
#pragma once

namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace emberline {

// One line that names the option and what is valid. `root`: what has parsed.
[[noreturn]] void throw_usage(const CLI::App& root, const CLI::ParseError& error);

}  // namespace emberline
