// The Huffman tables of BasisLZ (KTX specification, appendix "BasisLZ/ETC1S Bitstream").
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "io/image/ktx2/bit_reader.h"

namespace emberline::ktx2 {

class HuffmanTable {
 public:
  HuffmanTable() = default;  // no symbols
  // Builds canonical codes (RFC 1951, section 3.2.2) from each symbol's code length, 0 to 16 bits.
  // Throws InputError unless the code is complete, has a single symbol, or is empty. An empty table
  // cannot decode anything.
  HuffmanTable(std::span<const uint8_t> lengths, const std::string& place);
  // Reads a table from the stream, as in the section "Compressed Huffman Tables".
  static HuffmanTable read(BitReader& bits);

  // Throws InputError if no symbol has the code.
  uint32_t decode(BitReader& bits) const;

 private:
  static constexpr int kMaxCodeLength = 16;
  std::array<uint32_t, kMaxCodeLength + 1> counts_ = {};  // number of codes of each length
  std::vector<uint16_t> symbols_;                         // in code order
};

}  // namespace emberline::ktx2
