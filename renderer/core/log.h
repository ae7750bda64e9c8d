// Messages to the person at the terminal, on stderr. Thread-safe. Each is one line, whatever the
// names in it hold: control characters are spelled out (utf8.h).
//
// Results (info, compare --json) go to stdout and do not pass through here. A progress bar that
// shares the terminal is cleared before a message and redrawn after it.
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
// Unless --quiet; each distinct text once per process, and a hundred of them at most.
void log_warning(std::string_view message);
void log_info(std::string_view message);     // unless --quiet
void log_verbose(std::string_view message);  // with --verbose

// Where messages go instead of stderr, as they are, warnings each time; null: to stderr again. One
// call at a time.
enum class LogKind { kError, kWarning, kInfo };
void set_log_sink(std::function<void(LogKind kind, std::string_view message)> sink);

// Every text that log_warning has been given so far, in order: also those that --quiet kept back.
std::vector<std::string> warnings_so_far();

// Forgets all of those but the first `count`; they are given again when they come again. For a
// frame's own, when the next one begins.
void forget_warnings(size_t count);

// Called around each message so that a progress line can get out of the way. Null to remove.
void set_log_interrupt(std::function<void()> before, std::function<void()> after);

}  // namespace emberline
