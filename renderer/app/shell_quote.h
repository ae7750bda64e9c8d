// Words for a shell, so that a command can be shown, copied and run again.
#pragma once

#include <string>
#include <string_view>

namespace emberline {

// `argument` as one word that a POSIX shell reads as it is. Printable UTF-8 is quoted; what holds
// control characters or bytes that are no text, which would not survive being shown, is spelled as
// "$(printf '...')" with octal escapes, and stays on one line.
std::string shell_quoted(std::string_view argument);

// "emberline" and the quoted arguments.
std::string shell_command(int argc, const char* const* argv);

}  // namespace emberline
