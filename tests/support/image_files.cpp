#include "support/image_files.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfOutputFile.h>
#include <dlfcn.h>
#include <png.h>

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

void write_exr(const std::string& path, int width, int height, int channels,
               std::vector<float> texels) {
  constexpr const char* kNames[] = {"R", "G", "B", "A"};
  Imf::Header header(width, height);
  Imf::FrameBuffer buffer;
  const auto pixel = sizeof(float) * size_t(channels);
  for (int c = 0; c < channels; ++c) {
    const char* const name = channels == 1 ? "Y" : kNames[c];
    header.channels().insert(name, Imf::Channel(Imf::FLOAT));
    buffer.insert(name, Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(&texels[size_t(c)]), pixel,
                                   pixel * size_t(width)));
  }
  Imf::OutputFile file(path.c_str(), header);
  file.setFrameBuffer(buffer);
  file.writePixels(height);
}

BytePicture read_png(const std::string& path) {
  png_image image = {};
  image.version = PNG_IMAGE_VERSION;
  BytePicture picture;
  if (png_image_begin_read_from_file(&image, path.c_str())) {
    image.format &= PNG_FORMAT_FLAG_COLOR | PNG_FORMAT_FLAG_ALPHA;  // 8 bits, without a palette
    picture.width = int(image.width);
    picture.height = int(image.height);
    picture.channels = int(PNG_IMAGE_SAMPLE_CHANNELS(image.format));
    picture.values.resize(PNG_IMAGE_SIZE(image));
    png_image_finish_read(&image, nullptr, picture.values.data(), 0, nullptr);
  }
  if (PNG_IMAGE_FAILED(image)) throw std::runtime_error(path + ": " + image.message);
  return picture;
}

}  // namespace

void write_floats(const std::string& path, int width, int height, int channels,
                  const std::vector<float>& texels) {
  if (path.ends_with(".exr")) return write_exr(path, width, height, channels, texels);
  library().write(path, width, height, channels, texels);
}

std::vector<BytePicture> read_animation(const std::string& path) { return library().read(path); }

BytePicture read_bytes_picture(const std::string& path) {
  return path.ends_with(".png") ? read_png(path) : read_animation(path).at(0);
}

}  // namespace emberline::test
