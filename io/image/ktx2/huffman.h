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
  HuffmanTable() = default;  // without symbols
  // Of the number of bits of each symbol, 0 to 16; canonical codes (RFC 1951, section 3.2.2). A
  // table may be without symbols: then none can be read. Throws InputError unless the codes are
  // prefixes of one another nowhere and leave none out, but for the code of a single symbol.
  HuffmanTable(std::span<const uint8_t> lengths, const std::string& place);
  // As it stands in a stream: "Compressed Huffman Tables".
  static HuffmanTable read(BitReader& bits);

  // Throws InputError where no symbol has the code.
  uint32_t decode(BitReader& bits) const;

 private:
  static constexpr int kLongest = 16;
  std::array<uint32_t, kLongest + 1> counts_ = {};  // codes of each length
  std::vector<uint16_t> symbols_;                   // by code
};

}  // namespace emberline::ktx2
