#include "io/image/picture_mark.h"

#include <algorithm>
#include <cstdint>
#include <string_view>

#include "io/image/byte_cursor.h"
#include "renderer/core/errors.h"

namespace emberline {
namespace {

// What stands before a picture's pixels; more than any program of ours writes there.
constexpr size_t kMostHeader = size_t(1) << 20;

bool exr_is_marked(ByteCursor& header) {
  header.skip(4);  // version
  while (!header.at_end()) {
    const std::string name = header.until_zero();
    if (name.empty()) break;
    header.until_zero();  // type
    const uint64_t size = header.little_endian(4);
    constexpr std::string_view kNo = "false";
    if (name == kCompleteAttribute) return size >= kNo.size() && header.take_if(kNo);
    header.skip(size);
  }
  return false;
}

bool png_is_marked(ByteCursor& header) {
  while (!header.at_end()) {
    const uint64_t size = header.big_endian(4), data = header.offset() + 4;
    if (header.take_if("IDAT")) break;
    if (header.take_if("tEXt") && size == kIncompletePngText.size() &&
        header.take_if(kIncompletePngText)) {
      return true;
    }
    header.go_to(data);
    header.skip(size);
    header.skip(4);  // checksum
  }
  return false;
}

bool jpeg_is_marked(ByteCursor& header) {
  while (header.take_if("\xff")) {
    const uint8_t marker = header.byte();
    const uint64_t size = std::max<uint64_t>(header.big_endian(2), 2) - 2, data = header.offset();
    if (marker == 0xda) break;  // the pixels
    if (marker == 0xfe && size == kIncompleteComment.size() && header.take_if(kIncompleteComment)) {
      return true;
    }
    header.go_to(data);
    header.skip(size);
  }
  return false;
}

}  // namespace

bool is_marked_incomplete(const std::string& path) {
  const InputFile file(path);
  ByteCursor header(file, kMostHeader);
  if (header.take_if("\x76\x2f\x31\x01")) return exr_is_marked(header);
  if (header.take_if("\x89PNG\r\n\x1a\n")) return png_is_marked(header);
  if (header.take_if("\xff\xd8")) return jpeg_is_marked(header);
  throw InputError(path, "is no EXR, PNG or JPEG");
}

}  // namespace emberline
