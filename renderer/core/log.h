// Messages to the user on stderr. Thread-safe. Each message is one line: control characters in
// names are escaped (utf8.h).
//
// Results (info, compare --json) go to stdout and do not pass through here. A progress line on the
// same terminal is cleared before a message and redrawn after it.
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
// Shown unless --quiet; each distinct text once per process, and at most a hundred of them.
void log_warning(std::string_view message);
void log_info(std::string_view message);     // unless --quiet
void log_verbose(std::string_view message);  // with --verbose

// Redirects messages from stderr to `sink`, without a prefix and with repeated warnings; null
// restores stderr. One call at a time.
enum class LogKind { kError, kWarning, kInfo };
void set_log_sink(std::function<void(LogKind kind, std::string_view message)> sink);

// Every distinct warning so far, in order, including those that --quiet suppressed.
std::vector<std::string> warnings_so_far();

// Forgets all but the first `count` warnings between frames, so that they are shown again.
void truncate_warnings(size_t count);

// Called before and after each message, to clear and redraw a progress line. Null: none.
void set_log_hooks(std::function<void()> before, std::function<void()> after);

}  // namespace emberline
