// Image files, written and read by OpenImageIO. It brings some 240 libraries along, which take 0.4
// s of processor time, and every test is a process: so it is loaded with the first such file
// (image_files.cpp), which most tests of a program never see.
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

// Each throws std::runtime_error.
// `texels` interleaved, rows from the top; as floats, where the format that `path` ends in has
// them.
void write_floats(const std::string& path, int width, int height, int channels,
                  const std::vector<float>& texels);
BytePicture read_bytes_picture(const std::string& path);
// One for each picture of an animation.
std::vector<BytePicture> read_animation(const std::string& path);

// What the library exports.
struct ImageFiles {
  decltype(&write_floats) write;
  decltype(&read_animation) read;
};
extern "C" const ImageFiles emberline_test_image_files;

}  // namespace emberline::test
