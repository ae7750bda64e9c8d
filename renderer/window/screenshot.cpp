#include "renderer/window/screenshot.h"

#include <GLFW/glfw3.h>

#include <algorithm>
#include <chrono>
#include <vector>

#include "io/image/output.h"

namespace emberline {

void Screenshot::take(GLFWwindow* window, const std::string& path) {
  if (is_writing()) return;
  ByteImage image;
  glfwGetFramebufferSize(window, &image.width, &image.height);
  const auto row = size_t(image.width) * 3;
  std::vector<uint8_t> rows(row * size_t(image.height));
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, image.width, image.height, GL_RGB, GL_UNSIGNED_BYTE, rows.data());
  path_ = path;
  pending_ = std::async(std::launch::async, [image, rows, row, path]() mutable {
    image.values.resize(rows.size());  // OpenGL's first row is the bottom row
    for (size_t y = 0; y < size_t(image.height); ++y) {
      std::copy_n(&rows[(size_t(image.height) - 1 - y) * row], row, &image.values[y * row]);
    }
    write_image(path, image);
  });
}

bool Screenshot::finish(std::string* path) {
  if (!is_writing() || pending_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) {
    return false;
  }
  *path = path_;
  pending_.get();
  return true;
}

}  // namespace emberline
