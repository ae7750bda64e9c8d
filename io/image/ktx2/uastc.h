// UASTC blocks: 4 x 4 pixels in 128 bits. Khronos Data Format Specification 1.4, chapter "Universal
// ASTC Compressed Texture Images".
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "io/image/ktx2/container.h"

namespace emberline::ktx2 {

// Red, green, blue and alpha of each pixel, rows from the top.
using UastcPixels = std::array<std::array<uint8_t, 4>, kBlockPixels>;

// Any 16 bytes are a block: those that mean nothing are of the specification's colour of errors,
// (255, 0, 255, 255).
UastcPixels decode_uastc(std::span<const uint8_t, kUastcBlockBytes> block);

}  // namespace emberline::ktx2
