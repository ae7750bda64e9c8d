// Mutates images for libFuzzer. Corrects the checksums of a PNG's changed chunks, because the
// reader would reject the chunks otherwise.
#include <zlib.h>

#include <cstring>

#include "fuzz/fuzz.h"

namespace {

uint32_t big_endian(const uint8_t* bytes) {
  return uint32_t(bytes[0]) << 24 | uint32_t(bytes[1]) << 16 | uint32_t(bytes[2]) << 8 | bytes[3];
}

// A chunk consists of length, type, data, and the CRC of type and data (PNG specification, section
// 5.3).
void correct_png_checksums(uint8_t* data, size_t size) {
  if (size < 8 || std::memcmp(data, "\x89PNG\r\n\x1a\n", 8) != 0) return;
  for (size_t at = 8; size - at >= 12;) {
    const size_t length = big_endian(data + at);
    if (length > size - at - 12) return;
    const uint32_t crc = uint32_t(crc32(0, data + at + 4, uInt(length + 4)));
    for (size_t i = 0; i < 4; ++i) data[at + 8 + length + i] = uint8_t(crc >> (24 - 8 * i));
    at += length + 12;
  }
}

}  // namespace

extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t max_size,
                                          unsigned seed) {
  const size_t mutated = LLVMFuzzerMutate(data, size, max_size);
  if (seed % 8 != 0) correct_png_checksums(data, mutated);
  return mutated;
}
