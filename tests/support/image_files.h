// Writes and reads image files with OpenImageIO. Loading it and its 240 dependencies takes 0.4 s of
// processor time in each test, since each is a process. So it is loaded on the first use of these
// functions (image_files.cpp), which most tests never call.
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

// These throw std::runtime_error. `texels` are interleaved, in rows from the top; they are stored
// as floats if the format, which the suffix of `path` decides, supports floats.
void write_floats(const std::string& path, int width, int height, int channels,
                  const std::vector<float>& texels);
BytePicture read_bytes_picture(const std::string& path);
// Reads all frames of an animation.
std::vector<BytePicture> read_animation(const std::string& path);

// The functions that the library exports.
struct ImageFiles {
  decltype(&write_floats) write;
  decltype(&read_animation) read;
};
extern "C" const ImageFiles emberline_test_image_files;

}  // namespace emberline::test
