#include "support/image_files.h"

#include <dlfcn.h>

#include <stdexcept>

namespace emberline::test {
namespace {

#ifdef EMBERLINE_TEST_IMAGES

const ImageFiles& library() {
  static const ImageFiles* const loaded = [] {
    void* library = ::dlopen(EMBERLINE_TEST_IMAGES, RTLD_NOW | RTLD_LOCAL);
    void* found = library ? ::dlsym(library, "emberline_test_image_files") : nullptr;
    if (!found) throw std::runtime_error(::dlerror());
    return static_cast<const ImageFiles*>(found);
  }();
  return *loaded;
}

#else

const ImageFiles& library() { return emberline_test_image_files; }

#endif

}  // namespace

void write_floats(const std::string& path, int width, int height, int channels,
                  const std::vector<float>& texels) {
  library().write(path, width, height, channels, texels);
}

std::vector<BytePicture> read_animation(const std::string& path) { return library().read(path); }

BytePicture read_bytes_picture(const std::string& path) { return read_animation(path).at(0); }

}  // namespace emberline::test
