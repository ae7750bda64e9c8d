// `--journal F`: what the window does and shows, a line of JSON each, for reports of faults and for
// tests.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "io/files/atomic_file.h"

namespace emberline {

class Journal {
 public:
  // Lines wait until begin(): the file is not touched before it is known what the scene reads.
  // Throws RenderError for one that cannot be written.
  void wait(const std::string& path);
  bool waits() const { return !path_.empty() && !file_; }
  void begin();
  const std::string& path() const { return path_; }
  bool is_open() const { return !path_.empty(); }
  // {"t": seconds, "event": event, ...members}, at once, so that a reader can follow. Where that
  // fails, it is said and the journal closed: the window goes on.
  void write(const char* event, const nlohmann::json& members);

 private:
  void append(const std::string& lines);

  std::string path_, waiting_;
  std::optional<GrowingFile> file_;
};

}  // namespace emberline
