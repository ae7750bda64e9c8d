// Writes files one after another. If one of them fails, the others are still written.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace emberline {

// Not thread-safe.
class WriteAttempts {
 public:
  // Calls `write`. If it throws, logs one line, records the file as failed and returns false.
  bool attempt(const std::string& path, const std::function<void()>& write);

  const std::vector<std::string>& written() const { return written_; }
  const std::vector<std::string>& failed() const { return failed_; }

 private:
  std::vector<std::string> written_, failed_;
};

}  // namespace emberline
