// A place in a file of any size that is looked at byte by byte. For io/image alone.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "io/files/input_file.h"

namespace emberline {

// Bytes behind the end, and those that cannot be read, are 0.
class ByteCursor {
 public:
  // Of the file's first `most` bytes.
  explicit ByteCursor(const InputFile& file, uint64_t most = UINT64_MAX)
      : file_(file), size_(std::min(file.size(), most)) {}

  uint64_t offset() const { return offset_; }
  bool at_end() const { return offset_ >= size_; }
  bool is_behind_end() const { return offset_ > size_; }
  void skip(uint64_t count) { offset_ += std::min(count, size_ + 1); }
  void go_to(uint64_t offset) { offset_ = offset; }
  uint8_t byte() {
    if (offset_ < begin_ || offset_ >= begin_ + buffer_.size()) {
      begin_ = offset_;
      buffer_.resize(std::min<uint64_t>(kBytesAtOnce, at_end() ? 0 : size_ - offset_));
      const int64_t count = file_.try_read(begin_, buffer_.size(), buffer_.data());
      buffer_.resize(size_t(std::max<int64_t>(count, 0)));
    }
    const uint64_t at = offset_++ - begin_;
    return at < buffer_.size() ? buffer_[at] : 0;
  }
  uint64_t little_endian(int bytes) {
    uint64_t number = 0;
    for (int i = 0; i < bytes; ++i) number |= uint64_t(byte()) << (8 * i);
    return number;
  }
  uint64_t big_endian(int bytes) {
    uint64_t number = 0;
    for (int i = 0; i < bytes; ++i) number = number << 8 | byte();
    return number;
  }
  std::string until_zero() {
    std::string text;
    for (uint8_t c = byte(); c != 0; c = byte()) text += char(c);
    return text;
  }
  // Goes over the text if it stands here.
  bool take_if(std::string_view text) {
    const uint64_t before = offset_;
    const bool there =
        std::ranges::all_of(text, [&](char c) { return !at_end() && byte() == uint8_t(c); });
    if (!there) go_to(before);
    return there;
  }

 private:
  static constexpr size_t kBytesAtOnce = size_t(64) << 10;

  const InputFile& file_;
  const uint64_t size_;
  std::vector<uint8_t> buffer_;
  uint64_t begin_ = 0, offset_ = 0;
};

}  // namespace emberline
