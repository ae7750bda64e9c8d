// Quotes words for a shell, so that a command can be shown, copied and run again.
#pragma once

#include <string>
#include <string_view>

namespace emberline {

// Returns `argument` as one word that a POSIX shell reads back unchanged. Printable UTF-8 is put in
// quotes if it needs them. Text with control characters or invalid UTF-8, which a user could not
// copy, becomes "$(printf '...')" with octal escapes, on one line.
std::string shell_quoted(std::string_view argument);

// Returns "emberline" and the quoted arguments.
std::string shell_command(int argc, const char* const* argv);

}  // namespace emberline
