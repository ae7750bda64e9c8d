#include "io/image/picture_mark.h"

#include <cstdint>
#include <string_view>
#include <utility>

#include "io/files/input_file.h"
#include "renderer/core/errors.h"

namespace emberline {
namespace {

// What stands before a picture's pixels; more than any program of ours writes there.
constexpr size_t kMostHeader = size_t(1) << 20;

// The beginning of a file. What lies behind its end is empty, or 0.
class Header {
 public:
  explicit Header(const std::string& path) {
    const InputFile file(path);
    bytes_.resize(kMostHeader);
    const int64_t count = file.try_read(0, kMostHeader, bytes_.data());
    if (count < 0) throw InputError(path, "cannot be read");
    bytes_.resize(size_t(count));
    rest_ = bytes_;
  }

  bool at_end() const { return rest_.empty(); }
  std::string_view take(size_t count) {
    const std::string_view taken = rest_.substr(0, count);
    rest_.remove_prefix(taken.size());
    return taken;
  }
  bool take_if(std::string_view text) {
    const bool there = rest_.starts_with(text);
    if (there) take(text.size());
    return there;
  }
  std::string_view until_zero() {
    const std::string_view text = take(rest_.find('\0'));
    take(1);
    return text;
  }
  size_t big_endian(size_t bytes) {
    size_t number = 0;
    for (const char c : take(bytes)) number = number << 8 | uint8_t(c);
    return number;
  }
  size_t little_endian(size_t bytes) {
    size_t number = 0, shift = 0;
    for (const char c : take(bytes))
      number |= size_t(uint8_t(c)) << std::exchange(shift, shift + 8);
    return number;
  }

 private:
  std::string bytes_;
  std::string_view rest_;
};

bool exr_is_marked(Header& header) {
  header.take(4);  // version
  while (!header.at_end()) {
    const std::string_view name = header.until_zero();
    if (name.empty()) break;
    header.until_zero();  // type
    const std::string_view value = header.take(header.little_endian(4));
    if (name == kCompleteAttribute) return value.starts_with("false");
  }
  return false;
}

bool png_is_marked(Header& header) {
  while (!header.at_end()) {
    const size_t size = header.big_endian(4);
    const std::string_view type = header.take(4), data = header.take(size);
    if (type == "IDAT") break;
    if (type == "tEXt" && data == kIncompletePngText) return true;
    header.take(4);  // checksum
  }
  return false;
}

bool jpeg_is_marked(Header& header) {
  while (header.take_if("\xff")) {
    const std::string_view marker = header.take(1);
    const size_t size = header.big_endian(2);
    const std::string_view data = header.take(size < 2 ? 0 : size - 2);
    if (marker == "\xda") break;  // the pixels
    if (marker == "\xfe" && data == kIncompleteComment) return true;
  }
  return false;
}

}  // namespace

bool is_marked_incomplete(const std::string& path) {
  Header header(path);
  if (header.take_if("\x76\x2f\x31\x01")) return exr_is_marked(header);
  if (header.take_if("\x89PNG\r\n\x1a\n")) return png_is_marked(header);
  if (header.take_if("\xff\xd8")) return jpeg_is_marked(header);
  throw InputError(path, "is no EXR, PNG or JPEG");
}

}  // namespace emberline
