// Decodes level 0 of a KTX 2, one row of blocks at a time. For io/image/ktx2 only.
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
  // Decodes the next row of blocks. Alpha is 255 for ETC1S without a second slice. Throws
  // InputError if the data are damaged.
  virtual void next(std::span<BlockPixels> row) = 0;
};

// Returns the memory that the result of make_block_rows() takes, computed from the headers. Throws
// InputError.
uint64_t block_rows_bytes(const Container& container, const std::string& place);

// Makes a decoder that refers to the container's bytes, which must outlive it. Throws InputError.
std::unique_ptr<BlockRows> make_block_rows(const Container& container, const std::string& place);

// Decodes a UASTC block: 4 x 4 pixels in 128 bits (Khronos Data Format Specification 1.4, chapter
// "Universal ASTC Compressed Texture Images"). An invalid block decodes to the specification's
// error colour, (255, 0, 255, 255).
BlockPixels decode_uastc(std::span<const uint8_t, kUastcBlockBytes> block);

}  // namespace emberline::ktx2
