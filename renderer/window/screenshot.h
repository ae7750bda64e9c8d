// Writes screenshots of the window in the background, one at a time.
#pragma once

#include <future>
#include <string>

struct GLFWwindow;

namespace emberline {

// Used on the window's thread only. The destructor waits for pending writes.
class Screenshot {
 public:
  // Call after drawing and before swapping buffers, when the contents become undefined. Does
  // nothing while the previous one is being written.
  void take(GLFWwindow* window, const std::string& path);
  bool is_writing() const { return pending_.valid(); }
  // Whether one has been written since the last call, and its path. Throws the EmberlineError of
  // writing it; `path` is also set then.
  bool finish(std::string* path);

 private:
  std::future<void> pending_;
  std::string path_;
};

}  // namespace emberline
