// Implements `--journal F`: logs in JSON lines what the window does and shows, for bug reports and
// tests.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "io/files/atomic_file.h"

namespace emberline {

class Journal {
 public:
  // Buffers lines until begin(), because the file must not be overwritten while it might still be
  // one of the scene's inputs. Throws RenderError if the file cannot be written.
  void open_later(const std::string& path);
  bool is_buffering() const { return !path_.empty() && !file_; }
  void begin();
  const std::string& path() const { return path_; }
  bool is_open() const { return !path_.empty(); }
  // Writes the line {"t": seconds, "event": event, ...members}. After begin(), each line is written
  // immediately, so that another program can follow the journal. If writing fails, warns and closes
  // the journal.
  void write(const char* event, const nlohmann::json& members);

 private:
  void append(const std::string& lines);

  std::string path_, buffered_;
  std::optional<GrowingFile> file_;
};

}  // namespace emberline
