// Writes screenshots of the window in the background, one at a time.
#pragma once

#include <future>
#include <string>

struct GLFWwindow;

namespace emberline {

// Used on the window's thread only. The destructor waits for pending writes.
class Screenshot {
 public:
  // Call after drawing and before swapping buffers, which makes the buffer's contents undefined.
  // Does nothing while the previous screenshot is being written.
  void take(GLFWwindow* window, const std::string& path);
  bool is_writing() const { return pending_.valid(); }
  // Returns whether a screenshot has been written since the last call, and sets `path` to its file.
  // If writing failed, sets `path` and throws the EmberlineError.
  bool finish(std::string* path);

 private:
  std::future<void> pending_;
  std::string path_;
};

}  // namespace emberline
