#include "io/gltf/document/meshopt.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "io/files/byte_order.h"

namespace emberline {
namespace {

constexpr uint8_t kHeader = 0xa1;
constexpr size_t kGroupSize = 16;     // elements whose deltas are packed together
constexpr size_t kMaxElements = 256;  // per block
constexpr size_t kBlockBytes = 8192;  // approximate size of a decoded block
constexpr size_t kMaxStride = 256;
constexpr size_t kMinTail = 24;

size_t block_elements(size_t stride) {
  return std::min(kBlockBytes / stride & ~(kGroupSize - 1), kMaxElements);
}

// Reads the stream in order. take() returns null if fewer than `count` bytes remain.
class Stream {
 public:
  explicit Stream(std::span<const uint8_t> bytes) : bytes_(bytes) {}

  const uint8_t* take(size_t count) {
    if (count > bytes_.size() - at_) return nullptr;
    at_ += count;
    return bytes_.data() + at_ - count;
  }
  bool at_end() const { return at_ == bytes_.size(); }

 private:
  std::span<const uint8_t> bytes_;
  size_t at_ = 0;
};

// Reads sixteen deltas of `bits` bits each. If all bits of a delta are ones, its value follows as a
// byte.
bool read_group(Stream& stream, int bits, uint8_t* deltas) {
  if (bits == 0) {
    std::fill_n(deltas, kGroupSize, uint8_t(0));
    return true;
  }
  const uint8_t* packed = stream.take(kGroupSize * size_t(bits) / 8);
  if (!packed) return false;
  if (bits == 8) {
    std::copy_n(packed, kGroupSize, deltas);
    return true;
  }
  const unsigned sentinel = (1u << bits) - 1u;
  const size_t per_byte = 8 / size_t(bits);
  for (size_t i = 0; i < kGroupSize; ++i) {
    // Within a byte, 1-bit deltas start at the lowest bit, but wider deltas start at the highest
    // bit.
    const size_t place = bits == 1 ? i % per_byte : per_byte - 1 - i % per_byte;
    const unsigned value = packed[i / per_byte] >> (place * size_t(bits)) & sentinel;
    const uint8_t* exact = value == sentinel ? stream.take(1) : nullptr;
    if (value == sentinel && !exact) return false;
    deltas[i] = exact ? *exact : uint8_t(value);
  }
  return true;
}

// Reads the deltas of one byte plane (the bytes at the same offset in `count` elements). `deltas`
// must have room for whole groups.
bool read_deltas(Stream& stream, int control, size_t count, uint8_t* deltas) {
  const size_t groups = (count + kGroupSize - 1) / kGroupSize;
  if (control == 2) {
    std::fill_n(deltas, count, uint8_t(0));
    return true;
  }
  if (control == 3) {
    const uint8_t* literal = stream.take(count);
    if (literal) std::copy_n(literal, count, deltas);
    return literal != nullptr;
  }
  constexpr int kBits[2][4] = {{0, 1, 2, 4}, {1, 2, 4, 8}};
  const uint8_t* header = stream.take((groups + 3) / 4);
  if (!header) return false;
  for (size_t g = 0; g < groups; ++g) {
    const int mode = header[g / 4] >> (g % 4 * 2) & 3;
    if (!read_group(stream, kBits[control][mode], deltas + g * kGroupSize)) return false;
  }
  return true;
}

// Returns four bytes of an element, from the same bytes of the previous element (`last`) and their
// delta. The low four bits of `channel` are the mode.
uint32_t next_value(uint32_t last, uint32_t delta, uint8_t channel) {
  // In mode 2, the XOR difference was rotated to the left before it was stored.
  if ((channel & 15) == 2) return last ^ std::rotr(delta, channel >> 4);
  const int bits = (channel & 15) == 0 ? 8 : 16;
  const uint32_t mask = (1u << bits) - 1u;
  uint32_t value = 0;
  for (int shift = 0; shift < 32; shift += bits) {
    const uint32_t zigzag = delta >> shift & mask;
    const uint32_t difference = (zigzag & 1) ? ~(zigzag >> 1) : zigzag >> 1;
    value |= (((last >> shift & mask) + difference) & mask) << shift;
  }
  return value;
}

void store_u32(uint32_t value, uint8_t* bytes) {
  for (int i = 0; i < 4; ++i) bytes[i] = uint8_t(value >> (8 * i));
}

// On entry, `last` is the element before this block; on return, the block's last element.
bool read_block(Stream& stream, const uint8_t* channels, size_t count, size_t stride, uint8_t* last,
                uint8_t* decoded) {
  const uint8_t* controls = stream.take(stride / 4);
  if (!controls) return false;
  std::array<uint8_t, 4 * kMaxElements> deltas;
  for (size_t k = 0; k < stride; k += 4) {
    for (size_t b = 0; b < 4; ++b) {
      const int control = controls[k / 4] >> (2 * b) & 3;
      if (!read_deltas(stream, control, count, deltas.data() + b * kMaxElements)) return false;
    }
    uint32_t value = little_endian({last + k, 4}, 0, 4);
    for (size_t i = 0; i < count; ++i) {
      uint32_t delta = 0;
      for (size_t b = 0; b < 4; ++b) delta |= uint32_t(deltas[b * kMaxElements + i]) << (8 * b);
      value = next_value(value, delta, channels[k / 4]);
      store_u32(value, decoded + i * stride + k);
    }
    store_u32(value, last + k);
  }
  return true;
}

template <class Unsigned, class Signed>
void decode_color(uint8_t* element) {
  constexpr float kLargest = float(Unsigned(~Unsigned(0)));
  std::array<Unsigned, 4> in, out;
  std::memcpy(in.data(), element, sizeof(in));
  const int scale = (1 << std::bit_width(unsigned(in[3]))) - 1;
  const int y = in[0], co = Signed(in[1]), cg = Signed(in[2]);
  const int halved = in[3] & (scale >> 1);
  const int rgba[4] = {y + co - cg, y + cg, y - co - cg, halved << 1 | (halved & 1)};
  for (size_t c = 0; c < 4; ++c) {
    // Without the marker bit in alpha, the scale is 0 and the element is undefined.
    const float value = scale > 0 ? float(rgba[c]) * (kLargest / float(scale)) : 0.0f;
    out[c] = Unsigned(std::clamp(std::round(value), 0.0f, kLargest));
  }
  std::memcpy(element, out.data(), sizeof(out));
}

}  // namespace

bool is_meshopt_v1(std::span<const uint8_t> encoded) {
  return !encoded.empty() && encoded[0] == kHeader;
}

uint64_t min_meshopt_v1_size(uint64_t count, uint64_t stride) {
  const uint64_t block = block_elements(stride);
  return 1 + kMinTail + (count + block - 1) / block * (stride / 4);
}

bool decode_meshopt_v1(std::span<const uint8_t> encoded, size_t count, size_t stride,
                       uint8_t* decoded) {
  if (stride == 0 || stride % 4 != 0 || stride > kMaxStride) return false;
  // The stream ends with the padding, the initial value of `last`, and one mode for every four
  // bytes of an element.
  const size_t tail_data_bytes = stride + stride / 4;
  const size_t tail = std::max(tail_data_bytes, kMinTail);
  if (!is_meshopt_v1(encoded) || encoded.size() < 1 + tail) return false;
  std::array<uint8_t, kMaxStride> last;
  std::copy_n(encoded.data() + encoded.size() - tail_data_bytes, stride, last.data());
  const uint8_t* channels = encoded.data() + encoded.size() - stride / 4;
  for (size_t k = 0; k < stride / 4; ++k) {
    const int mode = channels[k] & 15;
    if (mode > 2 || (mode < 2 && channels[k] != mode)) return false;
  }
  Stream stream(encoded.subspan(1, encoded.size() - 1 - tail));
  const size_t block = block_elements(stride);
  for (size_t begin = 0; begin < count; begin += block) {
    const size_t elements = std::min(block, count - begin);
    if (!read_block(stream, channels, elements, stride, last.data(), decoded + begin * stride)) {
      return false;
    }
  }
  return stream.at_end();
}

void decode_meshopt_color(uint8_t* elements, size_t count, size_t stride) {
  for (size_t i = 0; i < count; ++i) {
    if (stride == 4) {
      decode_color<uint8_t, int8_t>(elements + i * stride);
    } else {
      decode_color<uint16_t, int16_t>(elements + i * stride);
    }
  }
}

}  // namespace emberline
