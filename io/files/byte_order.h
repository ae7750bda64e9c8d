// Reads integers of a given byte order. The machine's own order does not matter.
#pragma once

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <span>

namespace emberline {

// Returns the big-endian number in the `count` bytes at `offset`, which must lie in `bytes`.
template <typename Number = uint32_t>
Number big_endian(std::span<const uint8_t> bytes, size_t offset, size_t count) {
  assert(offset <= bytes.size() && count <= bytes.size() - offset && count <= sizeof(Number));
  Number value = 0;
  for (size_t i = 0; i < count; ++i) value = value << 8 | bytes[offset + i];
  return value;
}

// Returns the little-endian number in the `count` bytes at `offset`, which must lie in `bytes`.
template <typename Number = uint32_t>
Number little_endian(std::span<const uint8_t> bytes, size_t offset, size_t count) {
  assert(offset <= bytes.size() && count <= bytes.size() - offset && count <= sizeof(Number));
  Number value = 0;
  for (size_t i = count; i-- > 0;) value = value << 8 | bytes[offset + i];
  return value;
}

}  // namespace emberline
