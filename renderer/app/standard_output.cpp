#include "renderer/app/standard_output.h"

#include <cerrno>
#include <cstdio>
#include <system_error>

#include "renderer/core/errors.h"

namespace emberline {

void print_result(std::string_view text) {
  const bool written = std::fwrite(text.data(), 1, text.size(), stdout) == text.size();
  if (!written || std::fflush(stdout) != 0) {
    throw RenderError("cannot write the result to the standard output: " +
                      std::generic_category().message(errno));
  }
}

}  // namespace emberline
