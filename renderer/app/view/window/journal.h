// `--journal F`: what the window does and shows, a line of JSON each, for reports of faults and for
// tests.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "io/atomic_file.h"

namespace emberline {

class Journal {
 public:
  // Throws RenderError for a file that cannot be written.
  void open(const std::string& path);
  bool is_open() const { return file_.has_value(); }
  // {"t": seconds, "event": event, ...members}, at once, so that a reader can follow. Where that
  // fails, it is said and the journal closed: the window goes on.
  void write(const char* event, const nlohmann::json& members);

 private:
  std::optional<GrowingFile> file_;
};

}  // namespace emberline
