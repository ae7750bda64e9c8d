#include "renderer/window/input/journal.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/window/workbench/clock.h"

namespace emberline {

void Journal::open_later(const std::string& path) {
  check_writable(path);
  path_ = path;
}

void Journal::begin() {
  file_.emplace(path_);
  append(std::exchange(buffered_, {}));
}

void Journal::write(const char* event, const nlohmann::json& members) {
  if (!is_open()) return;
  nlohmann::json line = {{"t", window_time_s()}, {"event", event}};
  line.update(members);
  constexpr auto kReplace = nlohmann::json::error_handler_t::replace;  // names need not be UTF-8
  const std::string text = line.dump(-1, ' ', false, kReplace) + "\n";
  if (is_buffering()) {
    buffered_ += text;
  } else {
    append(text);
  }
}

void Journal::append(const std::string& lines) {
  try {
    file_->append(lines);
  } catch (const RenderError& error) {
    path_.clear();
    file_.reset();
    log_warning(std::string("stopped writing the journal: ") + error.what());
  }
}

}  // namespace emberline
