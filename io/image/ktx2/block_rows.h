// The pixels of a KTX 2's level 0, a row of blocks at a time. For io/image/ktx2 alone.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "io/image/ktx2/container.h"

namespace emberline::ktx2 {

class BlockRows {
 public:
  virtual ~BlockRows() = default;
  // Fills the next row of blocks: one each; of ETC1S without a second slice alpha is 255. Throws
  // InputError where the data are damaged.
  virtual void next(std::span<BlockPixels> row) = 0;
};

// Memory that make_block_rows takes, from what the headers say. Throws InputError.
uint64_t block_rows_bytes(const Container& container, const std::string& place);

// Refers to the container's bytes. Throws InputError.
std::unique_ptr<BlockRows> make_block_rows(const Container& container, const std::string& place);

// UASTC: 4 x 4 pixels in 128 bits. Khronos Data Format Specification 1.4, chapter "Universal ASTC
// Compressed Texture Images". Any 16 bytes are a block: those that mean nothing are of the
// specification's colour of errors, (255, 0, 255, 255).
BlockPixels decode_uastc(std::span<const uint8_t, kUastcBlockBytes> block);

}  // namespace emberline::ktx2
