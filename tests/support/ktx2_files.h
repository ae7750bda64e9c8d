// Reads the KTX 2 files of tests/support/ktx2, and helps to change them. tests/CMakeLists.txt
// defines EMBERLINE_KTX2, which is their folder. The offsets are from the KTX specification,
// section 2.
#pragma once

#include <array>

#include "support/temp_folder.h"

namespace emberline::test {

inline constexpr std::array kKtx2Files = {
    "etc1s_alpha",         "etc1s_base", "etc1s_linear",   "etc1s_odd",        "uastc_all_modes",
    "uastc2_blocks_alpha", "uastc_base", "uastc_gradient", "uastc_grey_alpha", "uastc_nozstd"};

inline std::vector<uint8_t> ktx2_file(const std::string& name) {
  return read_bytes(EMBERLINE_KTX2 "/" + name + ".ktx2");
}
// Reads the picture that the reference decoder made from a KTX 2 file.
inline std::vector<uint8_t> ktx2_reference(const std::string& name) {
  return read_bytes(EMBERLINE_KTX2 "/" + name + ".png");
}

inline uint32_t word_at(const std::vector<uint8_t>& bytes, size_t offset) {
  uint32_t value = 0;
  for (size_t i = 4; i-- > 0;) value = value << 8 | bytes.at(offset + i);
  return value;
}
inline void set_word(std::vector<uint8_t>& bytes, size_t offset, uint32_t value) {
  for (size_t i = 0; i < 4; ++i) bytes.at(offset + i) = uint8_t(value >> (8 * i));
}

// These functions return the offset of the basic descriptor, and the offset of the byte that
// contains a sample's channel.
inline size_t descriptor_of(const std::vector<uint8_t>& bytes) { return word_at(bytes, 48) + 4; }
inline size_t channel_of(const std::vector<uint8_t>& bytes, size_t sample) {
  return descriptor_of(bytes) + 24 + 16 * sample + 3;
}

}  // namespace emberline::test
