// Turns an exception into a one-line message and an exit code.
#pragma once

#include <exception>
#include <string>

namespace emberline {

struct Failure {
  std::string message;
  int exit_code = 0;
};

Failure failure_of(const std::exception& error);

}  // namespace emberline
