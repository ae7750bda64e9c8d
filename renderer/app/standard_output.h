// Prints results (of info, compare, --replay and --version) to stdout. Messages go to stderr
// (core/log.h).
#pragma once

#include <string_view>

namespace emberline {

// Writes the text and flushes stdout. Throws RenderError if this fails, because a full disk behind
// "> file" must not look like success.
void print_result(std::string_view text);

// Opens /dev/null for standard streams that are closed. Call this before any file is opened.
// Otherwise a file could get descriptor 2, and the log would be written to it. Writing a result to
// a closed standard output is still an error.
void replace_closed_streams();

}  // namespace emberline
