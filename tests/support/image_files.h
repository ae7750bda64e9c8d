// Writes and reads image files: EXR with OpenEXR, PNG with libpng, others with OpenImageIO. Each
// test is a process, in which loading OpenImageIO and its 240 dependencies takes 0.4 s of processor
// time, so it is loaded only when it is first used (image_files.cpp).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace emberline::test {

struct BytePicture {
  int width = 0, height = 0, channels = 0;
  std::vector<uint8_t> values;
  const uint8_t* at(int x, int y) const {
    return &values[size_t(y * width + x) * size_t(channels)];
  }
};

// These functions throw std::runtime_error if they cannot write or read the file. `texels` are
// interleaved, in rows from the top. The suffix of `path` decides the format. If the format
// supports floats, the texels are stored as floats.
void write_floats(const std::string& path, int width, int height, int channels,
                  const std::vector<float>& texels);
BytePicture read_bytes_picture(const std::string& path);
// Reads all frames of an animation.
std::vector<BytePicture> read_animation(const std::string& path);

// The library (image_files_library.cpp) exports these functions.
struct ImageFiles {
  decltype(&write_floats) write;
  decltype(&read_animation) read;
};
extern "C" const ImageFiles emberline_test_image_files;

}  // namespace emberline::test
