#include "renderer/app/view/window/journal.h"

#include <nlohmann/json.hpp>

#include "renderer/app/view/window/workbench.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"

namespace emberline {

void Journal::open(const std::string& path) { file_.emplace(path); }

void Journal::write(const char* event, const nlohmann::json& members) {
  if (!is_open()) return;
  nlohmann::json line = {{"t", Workbench::now()}, {"event", event}};
  line.update(members);
  constexpr auto kReplace = nlohmann::json::error_handler_t::replace;  // names need not be UTF-8
  try {
    file_->append(line.dump(-1, ' ', false, kReplace) + "\n");
  } catch (const RenderError& error) {
    file_.reset();
    log_warning(std::string("the journal ends here: ") + error.what());
  }
}

}  // namespace emberline
