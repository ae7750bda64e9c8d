// Results (info, compare, --replay, --version) go to stdout; messages go to stderr (core/log.h).
#pragma once

#include <string_view>

namespace emberline {

// Writes and flushes. Throws RenderError when it does not arrive: a full disk behind "> file" must
// not look like success.
void print_result(std::string_view text);

}  // namespace emberline
