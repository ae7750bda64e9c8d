// Errors that a user can cause, with one exception type per exit code. They are thrown only by code
// that loads scenes, reads or writes files, or parses options; hot code does not throw.
//
// Every message is one line that says what is wrong, where it is wrong (file, JSON pointer), and
// what the user can do. Write setting names in backticks (setting_names.h), and pass names and
// values that come from outside through shortened(). The constructor truncates an overlong message.
// A message without format arguments is taken literally, including braces.
#pragma once

#include <fmt/core.h>

#include <stdexcept>
#include <string>
#include <utility>

#include "renderer/core/setting_names.h"
#include "renderer/core/shortened.h"

namespace emberline {

// Documented exit codes of the command.
enum ExitCode : int {
  kExitDone = 0,
  kExitRenderFailed = 1,
  kExitUsage = 2,
  kExitInput = 3,
  kExitStopped = 130,
};

class EmberlineError : public std::runtime_error {
 public:
  EmberlineError(int exit_code, const std::string& message)
      : std::runtime_error(spell_setting_names(truncate_middle(message))), exit_code_(exit_code) {}
  int exit_code() const { return exit_code_; }

 private:
  int exit_code_;
};

// The command line is wrong (exit 2).
struct UsageError : EmberlineError {
  explicit UsageError(const std::string& message) : EmberlineError(kExitUsage, message) {}
  template <typename First, typename... Rest>
  explicit UsageError(fmt::format_string<First, Rest...> message, First&& first, Rest&&... rest)
      : UsageError(fmt::format(message, std::forward<First>(first), std::forward<Rest>(rest)...)) {}
};

// An input file cannot be used (exit 3). `place` is the file, followed by "#/json/pointer" if there
// is one.
struct InputError : EmberlineError {
  InputError(const std::string& place, const std::string& message)
      : EmberlineError(kExitInput, place + ": " + message) {}
  template <typename First, typename... Rest>
  InputError(const std::string& place, fmt::format_string<First, Rest...> message, First&& first,
             Rest&&... rest)
      : InputError(place,
                   fmt::format(message, std::forward<First>(first), std::forward<Rest>(rest)...)) {}
};

// The load as a whole exceeded a limit, so code that skips broken objects must not catch this.
struct LimitError : InputError {
  using InputError::InputError;
};

// Rendering or writing failed (exit 1).
struct RenderError : EmberlineError {
  explicit RenderError(const std::string& message) : EmberlineError(kExitRenderFailed, message) {}
  template <typename First, typename... Rest>
  explicit RenderError(fmt::format_string<First, Rest...> message, First&& first, Rest&&... rest)
      : RenderError(fmt::format(message, std::forward<First>(first), std::forward<Rest>(rest)...)) {
  }
};

}  // namespace emberline
