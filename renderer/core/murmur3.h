// 32-bit MurmurHash3 for x86 by A. Appleby (public domain, 2011), as the Cryptomatte specification
// requires. Bytes are read in little-endian order on any machine.
#pragma once

#include <bit>
#include <cstdint>
#include <string_view>

namespace emberline {

constexpr uint32_t murmur3_32(std::string_view text, uint32_t seed = 0) {
  constexpr uint32_t kFirst = 0xcc9e2d51u, kSecond = 0x1b873593u;
  const auto scrambled = [](uint32_t word) { return std::rotl(word * kFirst, 15) * kSecond; };
  const auto byte = [&](size_t i) { return uint32_t(static_cast<unsigned char>(text[i])); };
  uint32_t hash = seed;
  const size_t whole = text.size() / 4 * 4;
  for (size_t i = 0; i < whole; i += 4) {
    const uint32_t word = byte(i) | byte(i + 1) << 8 | byte(i + 2) << 16 | byte(i + 3) << 24;
    hash = std::rotl(hash ^ scrambled(word), 13) * 5 + 0xe6546b64u;
  }
  uint32_t tail = 0;
  for (size_t i = text.size(); i > whole; --i) tail = tail << 8 | byte(i - 1);
  hash ^= scrambled(tail);
  hash ^= uint32_t(text.size());
  hash = (hash ^ hash >> 16) * 0x85ebca6bu;
  hash = (hash ^ hash >> 13) * 0xc2b2ae35u;
  return hash ^ hash >> 16;
}

}  // namespace emberline
