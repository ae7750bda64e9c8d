#include "renderer/core/log.h"

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <atomic>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "renderer/core/setting_names.h"
#include "renderer/core/shortened.h"
#include "renderer/core/utf8.h"

namespace emberline {
namespace {

std::atomic<LogLevel> g_level{LogLevel::kNormal};

constexpr size_t kMaxPrintedWarnings = 100;

struct LogState {
  std::mutex mutex;
  std::set<std::string, std::less<>> warned;
  std::vector<std::string> warnings;  // in order of appearance
  std::function<void()> before;
  std::function<void(LogKind, std::string_view)> sink;
  std::shared_ptr<spdlog::logger> logger;

  LogState()
      : logger(std::make_shared<spdlog::logger>(
            "emberline", std::make_shared<spdlog::sinks::stderr_sink_st>())) {
    logger->set_pattern("%v");
    logger->set_level(spdlog::level::trace);
  }
};

LogState& state() {
  static LogState s;
  return s;
}

void write(LogKind kind, std::string_view prefix, std::string_view text) {
  LogState& s = state();
  const std::lock_guard lock(s.mutex);
  const std::string message = spell_setting_names(truncate_middle(text));
  if (s.sink) return s.sink(kind, message);
  if (s.before) s.before();
  s.logger->log(spdlog::level::info, "{}{}", prefix, printable(message));
  s.logger->flush();
}

}  // namespace

void set_log_level(LogLevel level) { g_level = level; }
LogLevel log_level() { return g_level; }

void set_log_sink(std::function<void(LogKind, std::string_view)> sink) {
  LogState& s = state();
  const std::lock_guard lock(s.mutex);
  s.sink = std::move(sink);
}

void log_error(std::string_view message) { write(LogKind::kError, "emberline: error: ", message); }

void log_warning(std::string_view text) {
  const std::string message = spell_setting_names(truncate_middle(text));
  size_t count = 0;
  {
    LogState& s = state();
    const std::lock_guard lock(s.mutex);
    if (s.sink) return s.sink(LogKind::kWarning, message);
    if (!s.warned.insert(message).second) return;
    s.warnings.push_back(message);
    count = s.warnings.size();
  }
  if (g_level == LogLevel::kQuiet || count > kMaxPrintedWarnings + 1) return;
  const bool is_printed = count <= kMaxPrintedWarnings;
  write(
      LogKind::kWarning, "emberline: warning: ",
      is_printed ? std::string_view(message) : "there are more warnings; `report` lists them all");
}

void log_info(std::string_view message) {
  if (g_level != LogLevel::kQuiet) write(LogKind::kInfo, "", message);
}

void log_verbose(std::string_view message) {
  if (g_level == LogLevel::kVerbose) write(LogKind::kInfo, "", message);
}

std::vector<std::string> warnings_so_far() {
  LogState& s = state();
  const std::lock_guard lock(s.mutex);
  return s.warnings;
}

void truncate_warnings(size_t count) {
  LogState& s = state();
  const std::lock_guard lock(s.mutex);
  for (; s.warnings.size() > count; s.warnings.pop_back()) s.warned.erase(s.warnings.back());
}

void set_log_hook(std::function<void()> before) {
  LogState& s = state();
  const std::lock_guard lock(s.mutex);
  s.before = std::move(before);
}

}  // namespace emberline
