#include "io/image/ktx2/block_rows.h"

#include <algorithm>
#include <cassert>

namespace emberline::ktx2 {
namespace {

constexpr BlockPixels kErrorColour = [] {
  BlockPixels pixels;
  pixels.fill({255, 0, 255, 255});
  return pixels;
}();

enum Channels : uint8_t { kLuminanceAlpha = 2, kRgb = 3, kRgba = 4 };
enum Digits : uint8_t { kBits = 0, kTrits = 3, kQuints = 5 };  // type of an endpoint's upper part

// A row of the tables "Mode Index encoding", "Block configuration bits", "Endpoint bits", "Block
// endpoint description prefix" and "weight bits".
struct Mode {
  uint8_t code_bits, code;  // `code` is the block's lowest `code_bits` bits
  uint8_t hint_bits;        // number of hint bits for transcoders
  bool has_etc2_hints;  // whether the last 8 hint bits are for ETC2; their upper half must not be 0
  uint8_t pattern_bits;
  bool selects_channel;  // whether the block states the channel of plane 2; if not, it is alpha
  uint8_t subsets, planes;
  Channels channels;
  Digits digits;
  uint8_t endpoint_bits, weight_bits;
};

constexpr uint8_t kSolid = 8, kModeCount = 19;
constexpr std::array<Mode, kModeCount> kModes = {{
    {4, 0x01, 15, false, 0, false, 1, 1, kRgb, kTrits, 6, 4},
    {6, 0x35, 15, false, 0, false, 1, 1, kRgb, kBits, 8, 2},
    {5, 0x1d, 15, false, 5, false, 2, 1, kRgb, kBits, 4, 3},
    {5, 0x03, 15, false, 4, false, 3, 1, kRgb, kTrits, 2, 2},
    {5, 0x13, 15, false, 5, false, 2, 1, kRgb, kQuints, 3, 2},
    {5, 0x0b, 15, false, 0, false, 1, 1, kRgb, kBits, 8, 3},
    {5, 0x1b, 15, false, 0, true, 1, 2, kRgb, kQuints, 5, 2},
    {5, 0x07, 15, false, 5, false, 2, 1, kRgb, kQuints, 3, 2},
    {5, 0x17, 0, false, 0, false, 1, 1, kRgba, kBits, 8, 0},  // solid colour
    {5, 0x0f, 23, true, 5, false, 2, 1, kRgba, kBits, 4, 2},
    {3, 0x02, 17, true, 0, false, 1, 1, kRgba, kTrits, 4, 4},
    {2, 0x00, 17, true, 0, true, 1, 2, kRgba, kTrits, 4, 2},
    {3, 0x06, 17, true, 0, false, 1, 1, kRgba, kTrits, 6, 3},
    {5, 0x1f, 23, true, 0, true, 1, 2, kRgba, kBits, 8, 1},
    {5, 0x0d, 23, true, 0, false, 1, 1, kRgba, kBits, 8, 2},
    {7, 0x05, 23, true, 0, false, 1, 1, kLuminanceAlpha, kBits, 8, 4},
    {6, 0x15, 23, true, 5, false, 2, 1, kLuminanceAlpha, kBits, 8, 2},
    {6, 0x25, 23, true, 0, false, 1, 2, kLuminanceAlpha, kBits, 8, 2},
    {4, 0x09, 15, false, 0, false, 1, 1, kRgb, kBits, 5, 5},
}};

// The subset of each pixel. A pattern has one or two bits per pixel, with the first pixel in the
// lowest bits.
constexpr std::array<uint16_t, 30> kTwoSubsets = {  // modes 2, 4, 9 and 16
    0xcccc, 0x8888, 0x1111, 0xecc8, 0x377f, 0xfeec, 0x0137, 0x137f, 0xc800, 0x0013,
    0xfe80, 0x17ff, 0x0017, 0x00ff, 0xfff0, 0x0fff, 0xff71, 0x8eff, 0x08ce, 0x008c,
    0x7310, 0xceff, 0x7331, 0x088c, 0xceef, 0x6666, 0xf00f, 0x5555, 0x0f0f, 0x36c9};
constexpr std::array<uint16_t, 19> kTwoSubsetsOfMode7 = {
    0x00f0, 0x4444, 0x0133, 0xcc80, 0xf0ff, 0x2222, 0xffc8, 0xccce, 0x3c03, 0x00ee,
    0x7700, 0x3003, 0x00ce, 0xff80, 0x6fff, 0x1333, 0x11ff, 0x136c, 0x00ef};
constexpr std::array<uint32_t, 11> kThreeSubsets = {  // mode 3
    0xa5a50000, 0xaa005555, 0xaa000055, 0x0000aa55, 0x25252525, 0x94949494,
    0x58585858, 0x56560202, 0x92929292, 0x55aa0055, 0xa05050a0};

using Subsets = std::array<uint8_t, kBlockPixels>;

bool find_subsets(size_t mode, size_t pattern, Subsets& subsets) {
  const auto spread = [&](uint32_t bits, size_t width) {
    for (size_t i = 0; i < kBlockPixels; ++i) {
      subsets[i] = uint8_t(bits >> (width * i) & ((1u << width) - 1));
    }
    return true;
  };
  if (kModes[mode].subsets == 1) return spread(0, 1);
  if (mode == 3) return pattern < kThreeSubsets.size() && spread(kThreeSubsets[pattern], 2);
  if (mode == 7) {
    return pattern < kTwoSubsetsOfMode7.size() && spread(kTwoSubsetsOfMode7[pattern], 1);
  }
  return pattern < kTwoSubsets.size() && spread(kTwoSubsets[pattern], 1);
}

// The 128 bits of a block, which are read from the lowest bit on.
class BlockBits {
 public:
  explicit BlockBits(std::span<const uint8_t, kUastcBlockBytes> block) {
    for (size_t i = 8; i-- > 0;) {
      low_ = low_ << 8 | block[i];
      high_ = high_ << 8 | block[i + 8];
    }
  }
  uint32_t peek(int count) const { return uint32_t(low_ & ((uint64_t(1) << count) - 1)); }
  uint32_t take(int count) {  // 0 to 31
    const uint32_t value = peek(count);
    if (count > 0) {
      low_ = low_ >> count | high_ << (64 - count);
      high_ >>= count;
    }
    taken_ += count;
    assert(taken_ <= 128);
    return value;
  }

 private:
  uint64_t low_ = 0, high_ = 0;
  int taken_ = 0;
};

// Follows "ASTC Endpoint Unquantization": combines a value's lower bits and its trit or quint into
// 8 bits. `b` is column B of that table: copies of all bits above the lowest bit, at the positions
// noted in each row.
uint8_t unquantize(Digits digits, int bit_count, uint32_t bits, uint32_t digit) {
  const uint32_t upper = bits >> 1;
  const std::array<uint32_t, 5> b = {
      upper << 8 | upper << 4 | upper << 2 | upper << 1,  // 2 bits: 0..11, trits: b000b0bb0
      upper << 7 | upper << 1 | upper >> 1,               // 3: 0..39, quints: cb0000cbc
      upper << 6 | upper,                                 // 4: 0..47, trits: dcb000dcb
      upper << 5 | upper >> 3,                            // 5: 0..159, quints: edcb0000e
      upper << 4 | upper >> 4};                           // 6: 0..191, trits: fedcb000f
  constexpr std::array<uint32_t, 5> kC = {93, 26, 22, 6, 5};
  assert(digits == (bit_count == 3 || bit_count == 5 ? kQuints : kTrits));
  static_cast<void>(digits);
  const size_t row = size_t(bit_count) - 2;
  const uint32_t a = (bits & 1) != 0 ? 0x1ff : 0;
  return uint8_t((a & 0x80) | ((digit * kC[row] + b[row]) ^ a) >> 2);
}

// The endpoint values in storage order: for each subset, a low and a high value per channel.
constexpr size_t kMaxValues = 18;
using Values = std::array<uint8_t, kMaxValues>;

Values take_values(const Mode& mode, BlockBits& bits) {
  const size_t count = size_t(2 * mode.channels * mode.subsets);
  std::array<uint32_t, kMaxValues> digits = {};
  // Five trits or three quints are stored as one number. The last group may have fewer trits or
  // quints, in fewer bits.
  const size_t group_size = mode.digits == kTrits ? 5 : 3;
  for (size_t i = 0; mode.digits != kBits && i < count; i += group_size) {
    const size_t group_count = std::min(group_size, count - i);
    constexpr std::array<int, 6> kTritBits = {0, 2, 4, 5, 7, 8}, kQuintBits = {0, 3, 5, 7, 0, 0};
    uint32_t packed = bits.take((mode.digits == kTrits ? kTritBits : kQuintBits)[group_count]);
    for (size_t k = 0; k < group_count; ++k, packed /= mode.digits)
      digits[i + k] = packed % mode.digits;
  }
  Values values = {};
  for (size_t i = 0; i < count; ++i) {
    const uint32_t value = bits.take(mode.endpoint_bits);
    if (mode.digits != kBits) {
      values[i] = unquantize(mode.digits, mode.endpoint_bits, value, digits[i]);
    } else {  // replicates 4, 5 or 8 bits to fill 8 bits
      const uint32_t left = value << (8 - mode.endpoint_bits);
      values[i] = uint8_t(left | left >> mode.endpoint_bits);
    }
  }
  return values;
}

// Follows "ASTC Weights Unquantization": replicates the bits to fill 6 bits, then maps the result
// to 0..64.
int unquantize_weight(uint32_t weight, int bit_count) {
  uint32_t value = 0;
  for (int shift = 6 - bit_count; shift > -bit_count; shift -= bit_count) {
    value |= shift >= 0 ? weight << shift : weight >> -shift;
  }
  return int(value > 32 ? value + 1 : value);
}

BlockPixels decode_solid(BlockBits bits) {
  std::array<uint8_t, 4> colour;
  for (uint8_t& channel : colour) channel = uint8_t(bits.take(8));
  BlockPixels pixels;
  pixels.fill(colour);
  return pixels;
}

}  // namespace

BlockPixels decode_uastc(std::span<const uint8_t, kUastcBlockBytes> block) {
  BlockBits bits(block);
  size_t index = 0;
  while (index < kModeCount && bits.peek(kModes[index].code_bits) != kModes[index].code) ++index;
  if (index == kModeCount) return kErrorColour;
  const Mode& mode = kModes[index];
  bits.take(mode.code_bits);
  if (index == kSolid) return decode_solid(bits);

  const uint32_t hints = bits.take(mode.hint_bits);
  // "ETC2M cannot be zero": ETC2M is the last four bits.
  if (mode.has_etc2_hints && hints >> (mode.hint_bits - 4) == 0) return kErrorColour;
  Subsets subsets;
  if (!find_subsets(index, bits.take(mode.pattern_bits), subsets)) return kErrorColour;
  const size_t second_channel = mode.planes == 1 ? 4 : mode.selects_channel ? bits.take(2) : 3;
  const Values values = take_values(mode, bits);

  // A subset's colours begin at `2 * channels * subset`: low red, high red, and so on.
  const auto end = [&](size_t subset, size_t channel, size_t high) {
    if (mode.channels == kRgb && channel == 3) return 255;
    const size_t stored = mode.channels == kLuminanceAlpha ? channel / 3 : channel;
    const int value = values[2 * (mode.channels * subset + stored) + high];
    return value;
  };

  BlockPixels pixels;
  std::array<bool, 3> has_weight = {};
  for (size_t i = 0; i < kBlockPixels; ++i) {
    const size_t subset = subsets[i];
    // The highest bit of the first weight of each subset is 0 and is not stored.
    const int stored = has_weight[subset] ? mode.weight_bits : mode.weight_bits - 1;
    has_weight[subset] = true;
    std::array<int, 2> weights = {};
    for (size_t plane = 0; plane < mode.planes; ++plane) {
      weights[plane] = unquantize_weight(bits.take(stored), mode.weight_bits);
    }
    for (size_t c = 0; c < 4; ++c) {
      const int weight = weights[c == second_channel ? 1 : 0];
      // Multiplying by 257 (0x101) expands 8 bits to 16 by replicating them.
      const int low = 257 * end(subset, c, 0), high = 257 * end(subset, c, 1);
      pixels[i][c] = uint8_t(((low * (64 - weight) + high * weight + 32) >> 6) >> 8);
    }
  }
  return pixels;
}

}  // namespace emberline::ktx2
