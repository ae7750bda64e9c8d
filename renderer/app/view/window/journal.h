// `--journal F`: what the window does and shows, a line of JSON each, for reports of faults and for
// tests.
#pragma once

#include <fstream>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace emberline {

class Journal {
 public:
  // Throws RenderError for a file that cannot be written.
  void open(const std::string& path);
  bool is_open() const { return file_.is_open(); }
  // {"t": seconds, "event": event, ...members}, flushed, so that a reader can follow.
  void write(const char* event, const nlohmann::json& members);

 private:
  std::ofstream file_;
};

}  // namespace emberline
