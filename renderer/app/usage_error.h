// Reports CLI11's errors in Emberline's wording.
#pragma once

namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace emberline {

// Throws UsageError with one line that names the option and what is valid. `root` is the parsed
// app.
[[noreturn]] void throw_usage(const CLI::App& root, const CLI::ParseError& error);

}  // namespace emberline
