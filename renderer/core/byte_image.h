// A picture of 8-bit values in memory: drawn, encoded, shown.
#pragma once

#include <cstdint>
#include <vector>

namespace emberline {

struct ByteImage {
  int width = 0, height = 0;
  int channels = 3;             // 1, 3, or 4 with alpha last, colour not multiplied by it
  std::vector<uint8_t> values;  // interleaved, row-major, display-encoded
  bool srgb = true;             // tag the file as sRGB
  bool incomplete = false;      // of a frame that was stopped: PNG and JPEG say so
};

}  // namespace emberline
