// Reads back what the command wrote, with the libraries that wrote nothing of it themselves: no
// code of io/ stands between the file and the test.
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
  std::map<std::string, std::vector<float>> channels;  // rows of the data window from the top
  std::map<std::string, std::string> types;            // "float", "half", "uint"
  std::map<std::string, std::string> attributes;       // the string ones
  int tile_size = 0;                                   // 0: in rows

  float at(const std::string& channel, int x, int y) const {
    return channels.at(channel)[size_t(y - data.y0) * size_t(data.width()) + size_t(x - data.x0)];
  }
};
// Throws std::exception for a file that OpenEXR cannot read whole.
ExrPicture read_exr(const std::string& path);

// The pixels of `a` and `b` that lie in both data windows have the same bits, channel by channel
// (those that depend on the clock apart). Returns what differs first, or "".
std::string first_difference(const ExrPicture& a, const ExrPicture& b);

}  // namespace emberline::test
