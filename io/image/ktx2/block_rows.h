// The pixels of a KTX 2's level 0, a row of blocks at a time. For io/image/ktx2 alone.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "io/image/ktx2/container.h"

namespace emberline::ktx2 {

// As a block holds them; of ETC1S without a second slice alpha is 255.
using BlockPixels = std::array<std::array<uint8_t, 4>, kBlockPixels>;

class BlockRows {
 public:
  virtual ~BlockRows() = default;
  // Fills the next row of blocks: one each. Throws InputError where the data are damaged.
  virtual void next(std::span<BlockPixels> row) = 0;
};

// Memory that make_block_rows takes, from what the headers say. Throws InputError.
uint64_t block_rows_bytes(const Container& container, const std::string& place);

// Refers to the container's bytes. Throws InputError.
std::unique_ptr<BlockRows> make_block_rows(const Container& container, const std::string& place);

}  // namespace emberline::ktx2
