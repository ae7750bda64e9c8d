// Reads bits as KTX 2 stores them, the least significant bit first. For io/image/ktx2 only.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <utility>

#include "io/image/ktx2/container.h"

namespace emberline::ktx2 {

// Reads a bit stream. Reading past the end throws an InputError that calls the data `name`.
class BitReader {
 public:
  BitReader(std::span<const uint8_t> bytes, std::string place, const char* name)
      : bytes_(bytes), place_(std::move(place)), name_(name) {}

  uint32_t take(int count) {  // 0 to 32 bits
    while (buffered_bit_count_ < count) {
      if (next_ == bytes_.size()) {
        throw_damaged(place_, std::string("has truncated ") + name_);
      }
      buffered_bits_ |= uint64_t(bytes_[next_++]) << buffered_bit_count_;
      buffered_bit_count_ += 8;
    }
    const uint32_t value = uint32_t(buffered_bits_ & ((uint64_t(1) << count) - 1));
    buffered_bits_ >>= count;
    buffered_bit_count_ -= count;
    return value;
  }

  const std::string& place() const { return place_; }

 private:
  std::span<const uint8_t> bytes_;
  std::string place_;
  const char* name_;
  size_t next_ = 0;
  uint64_t buffered_bits_ = 0;
  int buffered_bit_count_ = 0;
};

}  // namespace emberline::ktx2
