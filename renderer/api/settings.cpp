// Settings and process-wide functions.
#include <tbb/info.h>

#include <algorithm>
#include <utility>

#include "renderer/api/frame_parts.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/core/names.h"
#include "renderer/core/setting_names.h"
#include "renderer/core/version.h"
#include "renderer/engine/setting_rules.h"

namespace emberline::api {

std::string version() { return kEmberlineVersion; }

// Returns at most the machine's concurrency, because TBB warns on stderr if asked for more.
int arena_threads(const Resources& resources) {
  const int max_threads = tbb::info::default_concurrency();
  return resources.threads > 0 ? std::min(resources.threads, max_threads) : max_threads;
}

void check_resources(const Resources& resources) {
  if (resources.threads < 0 || resources.threads > kMaxThreads) {
    throw emberline::UsageError(
        "threads: {} is out of range; give 0 (one thread per processor) or 1 to {}",
        resources.threads, kMaxThreads);
  }
  if (resources.memory_bytes == 0)
    throw emberline::UsageError("`memory-limit`: the limit must be above 0");
  const double seconds = resources.load_timeout_s.value_or(1.0);
  if (!(seconds >= kMinLoadTimeout && seconds <= kMaxLoadTimeout)) {
    throw emberline::UsageError("`load-timeout`: {} is not a number from {} to {}", seconds,
                                kMinLoadTimeout, kMaxLoadTimeout);
  }
}

Settings::Settings() : state_(std::make_unique<State>()) {}
Settings::Settings(const Settings& other) : state_(std::make_unique<State>(*other.state_)) {}
Settings::Settings(Settings&& other) noexcept = default;
Settings& Settings::operator=(Settings other) noexcept {
  state_ = std::move(other.state_);
  return *this;
}
Settings::~Settings() = default;

Settings& Settings::set(std::string_view name, std::string_view text) {
  translate_errors([&] {
    find_named(setting_table(), "settings", "setting", name).read(state_->settings, text);
  });
  return *this;
}

std::string Settings::get(std::string_view name) const {
  return translate_errors([&] {
    return find_named(setting_table(), "settings", "setting", name).text(state_->settings);
  });
}

Settings& Settings::read(const std::string& path) {
  FrameSettings read = state_->settings;
  translate_errors([&] { read_settings(path, read); });
  state_->settings = std::move(read);
  return *this;
}

std::vector<Settings::Help> Settings::help() {
  std::vector<Help> all;
  for (const Setting& row : setting_table()) {
    const RulesHelp& rules = rules_of(row);
    const std::string fallback = default_of(row, FrameSettings());
    const std::string help = row.help.full + (fallback.empty() ? "" : " [" + fallback + "]");
    all.push_back({row.name, row.type, spell_setting_names(help + as_sentences(rules.rules)),
                   spell_setting_names(rules.values), is_load_setting(row.group)});
  }
  return all;
}

void spell_settings(SettingSpelling spelling) {
  constexpr emberline::SettingFormatter kPlain = [](std::string_view name) {
    return std::string(name);
  };
  constexpr emberline::SettingFormatter kUnderscores = [](std::string_view name) {
    std::string argument(name);
    std::ranges::replace(argument, '-', '_');
    return argument;
  };
  emberline::spell_settings(spelling == SettingSpelling::kUnderscores ? kUnderscores : kPlain);
}

void set_log(std::function<void(Message, std::string_view)> log) {
  if (!log) return set_log_sink({});
  set_log_sink([log = std::move(log)](LogKind kind, std::string_view message) {
    log(kind == LogKind::kError     ? Message::kError
        : kind == LogKind::kWarning ? Message::kWarning
                                    : Message::kInfo,
        message);
  });
}

}  // namespace emberline::api
