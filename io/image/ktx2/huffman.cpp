#include "io/image/ktx2/huffman.h"

namespace emberline::ktx2 {

HuffmanTable::HuffmanTable(std::span<const uint8_t> lengths, const std::string& place) {
  for (const uint8_t length : lengths) ++counts_[length];
  counts_[0] = 0;
  // The number of 16-bit sequences, out of all 2^16, that begin with one of the table's codes. If
  // the table is complete, all of them do.
  uint64_t taken = 0;
  size_t used = 0;
  std::array<uint32_t, kMaxCodeLength + 2> first = {};  // index of the first symbol of each length
  for (int length = 1; length <= kMaxCodeLength; ++length) {
    const uint32_t count = counts_[size_t(length)];
    taken += uint64_t(count) << (kMaxCodeLength - length);
    used += count;
    first[size_t(length) + 1] = uint32_t(used);
  }
  const uint64_t all = uint64_t(1) << kMaxCodeLength;
  if (taken > all || (taken < all && used > 1)) {
    throw_damaged(place, "has an invalid Huffman table");
  }
  symbols_.resize(used);
  for (size_t symbol = 0; symbol < lengths.size(); ++symbol) {
    const uint8_t length = lengths[symbol];
    if (length > 0) symbols_[first[length]++] = uint16_t(symbol);
  }
}

uint32_t HuffmanTable::decode(BitReader& bits) const {
  // Codes of the same length are consecutive numbers. Adding 1 to the last of them and doubling the
  // sum gives the first code of the next length.
  uint32_t code = 0, first = 0, index = 0;
  for (size_t length = 1; length <= kMaxCodeLength; ++length) {
    code |= bits.take(1);
    const uint32_t count = counts_[length];
    if (code - first < count) return symbols_[index + (code - first)];
    index += count;
    first = (first + count) << 1;
    code <<= 1;
  }
  throw_damaged(bits.place(), "has a Huffman code without a symbol");
}

HuffmanTable HuffmanTable::read(BitReader& bits) {
  constexpr std::array<uint8_t, 21> kOrder = {17, 18, 19, 20, 0,  8, 7,  9, 6,  10, 5,
                                              11, 4,  12, 3,  13, 2, 14, 1, 15, 16};
  const size_t total = bits.take(14), used = bits.take(5);
  if (total == 0) return HuffmanTable({}, bits.place());
  if (used == 0 || used > kOrder.size()) {
    throw_damaged(bits.place(), "has an invalid Huffman table");
  }
  std::array<uint8_t, kOrder.size()> code_lengths = {};
  for (size_t i = 0; i < used; ++i) code_lengths[kOrder[i]] = uint8_t(bits.take(3));
  const HuffmanTable codes(code_lengths, bits.place());
  std::vector<uint8_t> lengths;
  lengths.reserve(total);
  while (lengths.size() < total) {
    const uint32_t symbol = codes.decode(bits);
    if (symbol <= uint32_t(kMaxCodeLength)) {
      lengths.push_back(uint8_t(symbol));
      continue;
    }
    size_t run = 0;
    uint8_t length = 0;
    if (symbol == 17) {
      run = 3 + bits.take(3);
    } else if (symbol == 18) {
      run = 11 + bits.take(7);
    } else {
      run = symbol == 19 ? 3 + bits.take(2) : 7 + bits.take(7);
      length = lengths.empty() ? uint8_t(0) : lengths.back();
      if (length == 0) throw_damaged(bits.place(), "has a Huffman table with an invalid repeat");
    }
    if (run > total - lengths.size()) {
      throw_damaged(bits.place(), "has a Huffman table with more symbols than it declares");
    }
    lengths.insert(lengths.end(), run, length);
  }
  return HuffmanTable(lengths, bits.place());
}

}  // namespace emberline::ktx2
