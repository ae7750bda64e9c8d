// Writes pictures of the window, one after the other, in the background.
#pragma once

#include <future>
#include <string>

struct GLFWwindow;

namespace emberline {

// The window's thread only. Its end waits for what is being written.
class Screenshot {
 public:
  // Call after drawing and before the buffers are swapped, when their contents become undefined.
  // Does nothing while the previous one is being written.
  void take(GLFWwindow* window, const std::string& path);
  bool under_way() const { return written_.valid(); }
  // The path of the one that has been written since the last call. Throws what writing it threw,
  // an EmberlineError; `path` is set then, too.
  bool finish(std::string* path);

 private:
  std::future<void> written_;
  std::string path_;
};

}  // namespace emberline
