// Writes messages to the user on stderr. The functions are thread-safe. Each message is one line:
// control characters in names are escaped (utf8.h).
//
// Results, such as those of `info` and `compare --json`, go to stdout and do not use these
// functions. A progress line on the same terminal is cleared before a message and redrawn after it.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace emberline {

enum class LogLevel { kQuiet, kNormal, kVerbose };

void set_log_level(LogLevel level);
LogLevel log_level();

void log_error(std::string_view message);  // always shown: "emberline: error: ..."
// Not shown with --quiet. Each distinct warning is shown once (see also truncate_warnings()). After
// a hundred warnings, one last line says that there are more.
void log_warning(std::string_view message);
void log_info(std::string_view message);     // not shown with --quiet
void log_verbose(std::string_view message);  // shown only with --verbose

// Sends messages to `sink` instead of stderr, without a prefix and including repeated warnings;
// null restores stderr. One thread at a time calls the sink.
enum class LogKind { kError, kWarning, kInfo };
void set_log_sink(std::function<void(LogKind kind, std::string_view message)> sink);

// Returns every distinct warning so far, in order, including those that --quiet suppressed, but not
// those that went to a sink.
std::vector<std::string> warnings_so_far();

// Forgets all but the first `count` warnings, so that the others are shown again if they recur in
// the next frame.
void truncate_warnings(size_t count);

// Sets a function that is called before each message, to clear a progress line; null removes it.
void set_log_hook(std::function<void()> before);

}  // namespace emberline
