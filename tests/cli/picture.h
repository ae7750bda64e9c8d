// Reads the command's pictures with other libraries. Uses no code of io/.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "renderer/core/rect.h"
#include "support/image_files.h"

namespace emberline::test {

struct ExrPicture {
  Rect data, display;
  std::map<std::string, std::vector<float>> channels;  // rows of the data window, from the top
  std::map<std::string, std::string> types;            // "float", "half" or "uint"
  std::map<std::string, std::string> attributes;       // only attributes that are strings
  int tile_size = 0;                                   // 0 if the file has scan lines

  float at(const std::string& channel, int x, int y) const {
    return channels.at(channel)[size_t(y - data.y0) * size_t(data.width()) + size_t(x - data.x0)];
  }
};
// Throws std::exception for a file that OpenEXR cannot read completely.
ExrPicture read_exr(const std::string& path);

// Compares the pixels bit by bit, except in channels that depend on the clock. Returns a
// description of the first difference, or "" if there is none.
std::string first_difference(const ExrPicture& a, const ExrPicture& b);

}  // namespace emberline::test
