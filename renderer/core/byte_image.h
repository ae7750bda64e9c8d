// An image of 8-bit values in memory, for drawing, encoding and display.
#pragma once

#include <cstdint>
#include <vector>

namespace emberline {

struct ByteImage {
  int width = 0, height = 0;
  int channels = 3;             // 1, 3 or 4; the fourth is unassociated alpha
  std::vector<uint8_t> values;  // interleaved, row-major, display-encoded
  bool srgb = true;             // whether the encoded file is tagged as sRGB
  bool incomplete = false;      // the frame was stopped early; PNG and JPEG files record this
};

}  // namespace emberline
