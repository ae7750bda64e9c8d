#include "io/image/whole_picture.h"

#include <algorithm>
#include <cstdint>
#include <string_view>
#include <vector>

#include "io/files/input_file.h"

namespace emberline {
namespace {

// Reads a file from the front. Behind the end of the file there are zeros, and ended() says so.
class Cursor {
 public:
  explicit Cursor(const InputFile& file) : file_(file) {}

  uint64_t offset() const { return offset_; }
  bool ended() const { return offset_ > file_.size(); }
  void skip(uint64_t count) { offset_ += std::min(count, file_.size() + 1); }
  void go_to(uint64_t offset) { offset_ = offset; }
  uint8_t byte() {
    if (offset_ < begin_ || offset_ >= begin_ + buffer_.size()) {
      buffer_.resize(kBytesAtOnce);
      begin_ = offset_;
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

 private:
  static constexpr size_t kBytesAtOnce = size_t(64) << 10;

  const InputFile& file_;
  std::vector<uint8_t> buffer_;
  uint64_t begin_ = 0, offset_ = 0;
};

bool begins_with(const InputFile& file, std::string_view text) {
  Cursor cursor(file);
  return std::ranges::all_of(text, [&](char c) { return cursor.byte() == uint8_t(c); });
}

bool ends_with(const InputFile& file, std::string_view text) {
  if (file.size() < text.size()) return false;
  Cursor cursor(file);
  cursor.skip(file.size() - text.size());
  return std::ranges::all_of(text, [&](char c) { return cursor.byte() == uint8_t(c); });
}

struct ExrPart {
  bool tiled = false;
  uint8_t compression = 0;
};
struct ExrPartList {
  std::vector<ExrPart> list;
  bool several = false, readable = false;
};

// "OpenEXR File Layout": version and flags, then a header of attributes for each part.
ExrPartList read_exr_parts(Cursor& cursor) {
  constexpr uint64_t kTiled = 0x200, kDeep = 0x800, kSeveral = 0x1000;
  cursor.go_to(4);
  const uint64_t flags = cursor.little_endian(4);
  ExrPartList parts;
  parts.several = flags & kSeveral;
  if (flags & kDeep) return parts;
  while (!cursor.ended()) {
    ExrPart part = {.tiled = (flags & kTiled) != 0};
    bool empty = true;
    for (std::string name = cursor.until_zero(); !name.empty() && !cursor.ended();
         name = cursor.until_zero(), empty = false) {
      cursor.until_zero();  // its type
      const uint64_t size = cursor.little_endian(4), value = cursor.offset();
      if (parts.several && name == "type") part.tiled = cursor.byte() == 't';  // "tiledimage"
      if (name == "compression") part.compression = cursor.byte();
      cursor.go_to(value);
      cursor.skip(size);
    }
    parts.readable = !cursor.ended();
    if (empty) break;
    parts.list.push_back(part);
    if (!parts.several) break;
  }
  return parts;
}

// What a file system that lost power leaves has the right length, but zeros at the end. Packed
// pixels end with a checksum or codes (zip, piz, pxr24, dwa).
constexpr uint64_t kMostZeros = 8;

bool is_packed(uint8_t compression) {
  constexpr uint8_t kZips = 2, kPxr24 = 5, kDwaa = 8, kDwab = 9;
  return (compression >= kZips && compression <= kPxr24) || compression == kDwaa ||
         compression == kDwab;
}

bool ends_with_zeros(const InputFile& file, uint64_t count) {
  Cursor cursor(file);
  cursor.skip(file.size() - count);
  for (uint64_t i = 0; i < count; ++i) {
    if (cursor.byte() != 0) return false;
  }
  return true;
}

// The tables of offsets end where the first chunk begins, and the file does where the last one
// ends.
bool exr_is_whole(const InputFile& file) {
  Cursor cursor(file);
  const ExrPartList parts = read_exr_parts(cursor);
  if (!parts.readable) return false;
  uint64_t first = file.size(), last = 0;
  while (cursor.offset() < first) {
    const uint64_t offset = cursor.little_endian(8);
    if (cursor.ended() || offset >= file.size()) return false;
    first = std::min(first, offset);
    last = std::max(last, offset);
  }
  if (cursor.offset() != first || last == 0) return false;
  cursor.go_to(last);
  const uint64_t part = parts.several ? cursor.little_endian(4) : 0;
  if (part >= parts.list.size()) return false;
  cursor.skip(parts.list[part].tiled ? 16 : 4);  // its place
  const uint64_t size = cursor.little_endian(4);
  cursor.skip(size);
  if (size == 0 || cursor.offset() != file.size()) return false;
  return !is_packed(parts.list[part].compression) ||
         !ends_with_zeros(file, std::min(size, kMostZeros));
}

bool png_is_whole(const InputFile& file) {
  return ends_with(file, std::string_view("\0\0\0\0IEND\xae\x42\x60\x82", 12));
}

// Behind the header the end's marker stands nowhere else. Before it there may be small pictures,
// with an end of theirs.
bool jpeg_is_whole(const InputFile& file) {
  Cursor cursor(file);
  cursor.skip(2);
  constexpr uint8_t kScan = 0xda;
  for (uint8_t marker = 0; marker != kScan; cursor.skip(cursor.big_endian(2) - 2)) {
    if (cursor.byte() != 0xff || cursor.ended()) return false;
    for (marker = cursor.byte(); marker == 0xff;) marker = cursor.byte();
  }
  return !cursor.ended() && ends_with(file, "\xff\xd9");
}

bool gif_is_whole(const InputFile& file) {
  Cursor cursor(file);
  const auto skip_colours = [&](uint8_t flags) {
    if (flags & 0x80) cursor.skip(uint64_t(6) << (flags & 7));
  };
  cursor.skip(10);
  const uint8_t flags = cursor.byte();
  cursor.skip(2);
  skip_colours(flags);
  while (!cursor.ended()) {
    const uint8_t kind = cursor.byte();
    if (kind == ';') return cursor.offset() == file.size();
    if (kind == ',') {  // a picture, its colours, the width of its codes
      cursor.skip(8);
      skip_colours(cursor.byte());
      cursor.skip(1);
    } else if (kind == '!') {
      cursor.skip(1);
    } else {
      return false;
    }
    for (uint8_t size = cursor.byte(); size > 0; size = cursor.byte()) cursor.skip(size);
  }
  return false;
}

}  // namespace

bool is_whole_picture(const std::string& path) {
  const InputFile file(path);
  if (begins_with(file, "\x76\x2f\x31\x01")) return exr_is_whole(file);
  if (begins_with(file, "\x89PNG\r\n\x1a\n")) return png_is_whole(file);
  if (begins_with(file, "\xff\xd8\xff")) return jpeg_is_whole(file);
  if (begins_with(file, "GIF8")) return gif_is_whole(file);
  return false;
}

}  // namespace emberline
