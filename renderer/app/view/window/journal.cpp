#include "renderer/app/view/window/journal.h"

#include <nlohmann/json.hpp>

#include "renderer/app/view/window/workbench.h"
#include "renderer/core/errors.h"

namespace emberline {

void Journal::open(const std::string& path) {
  file_.open(path, std::ios::trunc);
  if (!file_) throw RenderError(path + ": cannot be written");
}

void Journal::write(const char* event, const nlohmann::json& members) {
  if (!is_open()) return;
  nlohmann::json line = {{"t", Workbench::now()}, {"event", event}};
  line.update(members);
  constexpr auto kReplace = nlohmann::json::error_handler_t::replace;  // names need not be UTF-8
  file_ << line.dump(-1, ' ', false, kReplace) << std::endl;
}

}  // namespace emberline
