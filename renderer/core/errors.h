// The errors a user can cause, one exception type per exit code. Thrown only at load and I/O
// boundaries and while options are read; hot code does not throw.
//
// Every message is one line: what is wrong, where (file, JSON pointer), what to do.
#pragma once

#include <stdexcept>
#include <string>

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
      : std::runtime_error(message), exit_code_(exit_code) {}
  int exit_code() const { return exit_code_; }

 private:
  int exit_code_;
};

// The command line is wrong (exit 2).
struct UsageError : EmberlineError {
  explicit UsageError(const std::string& message) : EmberlineError(kExitUsage, message) {}
};

// A file given to us cannot be used (exit 3). `place` is the file, with "#/json/pointer" behind it
// where one applies.
struct InputError : EmberlineError {
  InputError(const std::string& place, const std::string& message)
      : EmberlineError(kExitInput, place + ": " + message) {}
};

// Rendering or writing failed (exit 1).
struct RenderError : EmberlineError {
  explicit RenderError(const std::string& message) : EmberlineError(kExitRenderFailed, message) {}
};

}  // namespace emberline
