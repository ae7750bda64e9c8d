// Files that are written one after another, of which one that fails takes no other with it.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace emberline {

// Not thread-safe.
class WriteAttempts {
 public:
  // Calls `write`, which writes that file. What it throws is told at once, in one line of the log,
  // and the file counts as failed. False then.
  bool attempt(const std::string& path, const std::function<void()>& write);

  const std::vector<std::string>& written() const { return written_; }
  const std::vector<std::string>& failed() const { return failed_; }

 private:
  std::vector<std::string> written_, failed_;
};

}  // namespace emberline
