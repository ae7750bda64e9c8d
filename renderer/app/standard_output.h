// Results (info, compare, --replay, --version) go to stdout; messages go to stderr (core/log.h).
#pragma once

#include <string_view>

namespace emberline {

// Writes and flushes. Throws RenderError when it does not arrive: a full disk behind "> file" must
// not look like success.
void print_result(std::string_view text);

// Puts /dev/null where standard input, output or error are closed. To be called before anything
// opens a file: an output that becomes descriptor 2 would get the log's lines. A result for a
// closed standard output is still an error.
void replace_closed_streams();

}  // namespace emberline
