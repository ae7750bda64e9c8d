// Reads encoded bytes in order. For io/image only.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/files/input_file.h"

namespace emberline {

// The bytes of a file or of memory. Several threads may call `read` at once.
struct ByteSource {
  uint64_t size = 0;
  // Reads up to `count` bytes and returns how many.
  std::function<size_t(uint64_t offset, size_t count, void* bytes)> read;
};

// Reads the file on demand.
inline ByteSource make_byte_source(InputFile file) {
  const auto shared = std::make_shared<const InputFile>(std::move(file));
  return {shared->size(), [shared](uint64_t offset, size_t count, void* bytes) {
            return size_t(std::max<int64_t>(0, shared->try_read(offset, count, bytes)));
          }};
}

// A buffered reader. The source must outlive it.
class ByteCursor {
 public:
  // Reads at most the source's first `most` bytes.
  explicit ByteCursor(const ByteSource& source, uint64_t most = UINT64_MAX)
      : source_(source), size_(std::min(source.size, most)) {}

  uint64_t offset() const { return offset_; }
  bool at_end() const { return offset_ >= size_; }
  bool is_past_end() const { return offset_ > size_; }
  void skip(uint64_t count) { offset_ += std::min(count, size_ + 1); }
  void seek(uint64_t offset) { offset_ = offset; }
  // Reads up to `count` bytes and returns how many.
  size_t take(void* bytes, size_t count) {
    auto* to = static_cast<uint8_t*>(bytes);
    size_t left = count;
    while (left > 0) {
      if (offset_ < begin_ || offset_ >= begin_ + buffer_.size()) {
        begin_ = offset_;
        buffer_.resize(std::min<uint64_t>(kBufferBytes, at_end() ? 0 : size_ - offset_));
        buffer_.resize(source_.read(begin_, buffer_.size(), buffer_.data()));
        if (buffer_.empty()) break;
      }
      const size_t at = size_t(offset_ - begin_), part = std::min(left, buffer_.size() - at);
      to = std::copy_n(buffer_.data() + at, part, to);
      offset_ += part;
      left -= part;
    }
    return count - left;
  }
  // Returns 0 for a byte that is past the end or cannot be read.
  uint8_t byte() {
    uint8_t value = 0;
    if (take(&value, 1) == 0) ++offset_;
    return value;
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
  std::string read_c_string() {
    std::string text;
    for (uint8_t c = byte(); c != 0; c = byte()) text += char(c);
    return text;
  }
  // Skips `text` if it comes next.
  bool consume_if(std::string_view text) {
    const uint64_t before = offset_;
    const bool there =
        std::ranges::all_of(text, [&](char c) { return !at_end() && byte() == uint8_t(c); });
    if (!there) seek(before);
    return there;
  }

 private:
  static constexpr size_t kBufferBytes = size_t(64) << 10;

  const ByteSource& source_;
  const uint64_t size_;
  std::vector<uint8_t> buffer_;
  uint64_t begin_ = 0, offset_ = 0;
};

}  // namespace emberline
