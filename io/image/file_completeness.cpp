#include "io/image/file_completeness.h"

#include <algorithm>
#include <cstdint>
#include <string_view>
#include <vector>

#include "io/image/byte_cursor.h"
#include "renderer/core/errors.h"

namespace emberline {
namespace {

// The header is searched only up to this many bytes. The headers that we write are shorter.
constexpr size_t kMaxHeaderBytes = size_t(1) << 20;

// Calls `use` for each attribute of the first header, until `use` returns false. Passes the
// attribute's name, its type and the size of its value. During the call, the cursor is at the
// value. On entry, the cursor must be after the magic number.
template <typename Use>
void for_exr_attributes(ByteCursor& header, const Use& use) {
  header.skip(4);  // version
  while (!header.at_end()) {
    const std::string name = header.read_c_string();
    if (name.empty()) break;
    const std::string type = header.read_c_string();
    const uint64_t size = header.little_endian(4), value = header.offset();
    if (!use(name, type, size)) break;
    header.seek(value);
    header.skip(size);
  }
}

bool is_unfinished_exr(ByteCursor& header) {
  bool unfinished = false;
  for_exr_attributes(header, [&](const std::string& name, const std::string&, uint64_t size) {
    constexpr std::string_view kFalse = "false";
    if (name != kCompleteAttribute) return true;
    unfinished = size >= kFalse.size() && header.consume_if(kFalse);
    return false;
  });
  return unfinished;
}

bool is_unfinished_png(ByteCursor& header) {
  while (!header.at_end()) {
    const uint64_t size = header.big_endian(4), data = header.offset() + 4;
    if (header.consume_if("IDAT")) break;
    if (header.consume_if("tEXt") && size == kIncompletePngText.size() &&
        header.consume_if(kIncompletePngText)) {
      return true;
    }
    header.seek(data);
    header.skip(size);
    header.skip(4);  // checksum
  }
  return false;
}

bool is_unfinished_jpeg(ByteCursor& header) {
  while (header.consume_if("\xff")) {
    const uint8_t marker = header.byte();
    const uint64_t size = std::max<uint64_t>(header.big_endian(2), 2) - 2, data = header.offset();
    if (marker == 0xda) break;  // the pixels
    if (marker == 0xfe && size == kIncompleteComment.size() &&
        header.consume_if(kIncompleteComment)) {
      return true;
    }
    header.seek(data);
    header.skip(size);
  }
  return false;
}

bool ends_with(const ByteSource& file, std::string_view text) {
  if (file.size < text.size()) return false;
  ByteCursor cursor(file);
  cursor.skip(file.size - text.size());
  return cursor.consume_if(text);
}

struct ExrPart {
  bool tiled = false;
  uint8_t compression = 0;
};
struct ExrPartList {
  std::vector<ExrPart> list;
  bool is_multipart = false, readable = false;
};

// The format is that of "OpenEXR File Layout": version and flags, then one header of attributes per
// part.
ExrPartList read_exr_parts(ByteCursor& cursor) {
  constexpr uint64_t kTiled = 0x200, kDeep = 0x800, kMultipart = 0x1000;
  cursor.seek(4);
  const uint64_t flags = cursor.little_endian(4);
  ExrPartList parts;
  parts.is_multipart = flags & kMultipart;
  if (flags & kDeep) return parts;
  while (!cursor.is_past_end()) {
    ExrPart part = {.tiled = (flags & kTiled) != 0};
    bool empty = true;
    for (std::string name = cursor.read_c_string(); !name.empty() && !cursor.is_past_end();
         name = cursor.read_c_string(), empty = false) {
      cursor.read_c_string();  // type
      const uint64_t size = cursor.little_endian(4), value = cursor.offset();
      if (parts.is_multipart && name == "type") part.tiled = cursor.byte() == 't';  // "tiledimage"
      if (name == "compression") part.compression = cursor.byte();
      cursor.seek(value);
      cursor.skip(size);
    }
    parts.readable = !cursor.is_past_end();
    if (empty) break;
    parts.list.push_back(part);
    if (!parts.is_multipart) break;
  }
  return parts;
}

// After a power loss, a file can have the right length but end with zeros. A chunk that zip, piz,
// pxr24 or dwa has made smaller ends with a checksum or with codes, and never with this many zeros.
// A chunk that they cannot make smaller has plain pixels; these may end so, but seldom do.
constexpr uint64_t kMaxEndZeros = 8;

bool is_compressed(uint8_t compression) {
  constexpr uint8_t kZips = 2, kPxr24 = 5, kDwaa = 8, kDwab = 9;
  return (compression >= kZips && compression <= kPxr24) || compression == kDwaa ||
         compression == kDwab;
}

bool ends_with_zeros(const ByteSource& file, uint64_t count) {
  ByteCursor cursor(file);
  cursor.skip(file.size - count);
  for (uint64_t i = 0; i < count; ++i) {
    if (cursor.byte() != 0) return false;
  }
  return true;
}

// The offset tables must end at the first chunk, and the last chunk must end at the end of the
// file.
bool is_complete_exr(const ByteSource& file) {
  ByteCursor cursor(file);
  const ExrPartList parts = read_exr_parts(cursor);
  if (!parts.readable) return false;
  uint64_t first = file.size, last = 0;
  while (cursor.offset() < first) {
    const uint64_t offset = cursor.little_endian(8);
    if (cursor.is_past_end() || offset >= file.size) return false;
    first = std::min(first, offset);
    last = std::max(last, offset);
  }
  if (cursor.offset() != first || last == 0) return false;
  cursor.seek(last);
  const uint64_t part = parts.is_multipart ? cursor.little_endian(4) : 0;
  if (part >= parts.list.size()) return false;
  cursor.skip(parts.list[part].tiled ? 16 : 4);  // the chunk's coordinates
  const uint64_t size = cursor.little_endian(4);
  cursor.skip(size);
  if (size == 0 || cursor.offset() != file.size) return false;
  return !is_compressed(parts.list[part].compression) ||
         !ends_with_zeros(file, std::min(size, kMaxEndZeros));
}

bool is_complete_png(const ByteSource& file) {
  return ends_with(file, std::string_view("\0\0\0\0IEND\xae\x42\x60\x82", 12));
}

// Skips the headers before looking for the end marker, since thumbnails in the headers also have
// one.
bool is_complete_jpeg(const ByteSource& file) {
  ByteCursor cursor(file);
  cursor.skip(2);
  constexpr uint8_t kScan = 0xda;
  for (uint8_t marker = 0; marker != kScan; cursor.skip(cursor.big_endian(2) - 2)) {
    if (cursor.byte() != 0xff || cursor.is_past_end()) return false;
    for (marker = cursor.byte(); marker == 0xff;) marker = cursor.byte();
  }
  return !cursor.is_past_end() && ends_with(file, "\xff\xd9");
}

bool is_complete_gif(const ByteSource& file) {
  ByteCursor cursor(file);
  const auto skip_colours = [&](uint8_t flags) {
    if (flags & 0x80) cursor.skip(uint64_t(6) << (flags & 7));
  };
  cursor.skip(10);
  const uint8_t flags = cursor.byte();
  cursor.skip(2);
  skip_colours(flags);
  while (!cursor.is_past_end()) {
    const uint8_t kind = cursor.byte();
    if (kind == ';') return cursor.offset() == file.size;
    if (kind == ',') {  // an image: its palette, then the LZW code size
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

bool is_unfinished_image(const std::string& path) {
  const ByteSource file = make_byte_source(InputFile(path));
  ByteCursor header(file, kMaxHeaderBytes);
  if (header.consume_if("\x76\x2f\x31\x01")) return is_unfinished_exr(header);
  if (header.consume_if("\x89PNG\r\n\x1a\n")) return is_unfinished_png(header);
  if (header.consume_if("\xff\xd8")) return is_unfinished_jpeg(header);
  throw InputError(path, "is not an EXR, PNG or JPEG");
}

std::vector<std::pair<std::string, std::string>> exr_texts(const std::string& path,
                                                           std::string_view prefix) {
  const ByteSource file = make_byte_source(InputFile(path));
  ByteCursor header(file, kMaxHeaderBytes);
  std::vector<std::pair<std::string, std::string>> texts;
  if (!header.consume_if("\x76\x2f\x31\x01")) return texts;
  for_exr_attributes(header, [&](const std::string& name, const std::string& type, uint64_t size) {
    if (type == "string" && name.starts_with(prefix) && size <= kMaxHeaderBytes) {
      std::string text(size, '\0');
      text.resize(header.take(text.data(), size));
      texts.emplace_back(name, std::move(text));
    }
    return true;
  });
  return texts;
}

bool is_complete_file(const std::string& path) {
  const ByteSource file = make_byte_source(InputFile(path));
  ByteCursor cursor(file);
  if (cursor.consume_if("\x76\x2f\x31\x01")) return is_complete_exr(file);
  if (cursor.consume_if("\x89PNG\r\n\x1a\n")) return is_complete_png(file);
  if (cursor.consume_if("\xff\xd8\xff")) return is_complete_jpeg(file);
  if (cursor.consume_if("GIF8")) return is_complete_gif(file);
  return false;
}

}  // namespace emberline
