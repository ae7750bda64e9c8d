#include <algorithm>
#include <array>
#include <charconv>
#include <optional>

#include "io/image/encoded_image.h"
#include "io/image/input.h"
#include "renderer/core/errors.h"

namespace emberline {
namespace {

constexpr size_t kMaxExrHeaderBytes = size_t(16) << 20, kMaxHdrHeaderBytes = size_t(64) << 10;
// The limit is our choice. It is needed because decoders search attributes linearly. The largest
// real headers have a few hundred attributes.
constexpr int kMaxExrAttributes = 4000, kMaxAttributesOfAllParts = 50000;
// Memory of OpenEXR for each attribute or channel, and for the offset of each block (measured).
constexpr uint64_t kExrEntryBytes = 1024, kExrOffsetBytes = 16;
constexpr int64_t kMaxTileSide = 4096;

// Reads a header whose length is not known in advance.
class HeaderReader {
 public:
  HeaderReader(const ByteSource& source, size_t most, const char* format, const std::string& place)
      : cursor_(source), most_(most), format_(format), place_(place) {}

  uint64_t offset() const { return cursor_.offset(); }
  void skip(uint64_t count) { seek(offset() + count); }
  void seek(uint64_t offset) {
    cursor_.seek(offset);
    if (offset > most_) {
      throw InputError(place_, std::string("cannot decode the image: the header of the ") +
                                   format_ + " is longer than " + std::to_string(most_) + " bytes");
    }
  }
  uint8_t byte() {
    uint8_t value = 0;
    if (cursor_.take(&value, 1) == 0) throw_truncated(format_, place_);
    seek(offset());
    return value;
  }
  uint32_t word() {  // little-endian
    uint32_t value = 0;
    for (int i = 0; i < 4; ++i) value |= uint32_t(byte()) << (8 * i);
    return value;
  }
  std::string until(char end) {
    std::string text;
    for (char c = char(byte()); c != end; c = char(byte())) text += c;
    return text;
  }

 private:
  ByteCursor cursor_;
  const size_t most_;
  const char* format_;
  const std::string& place_;
};

// An axis of the resolution line: "-Y 512" has the sign '-', the letter 'Y' and the size 512.
struct HdrAxis {
  char sign = 0, letter = 0;
  int64_t size = 0;
};

std::optional<HdrAxis> read_hdr_axis(std::string_view& text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  if (text.size() < 4 || text[2] != ' ') return std::nullopt;
  HdrAxis axis{text[0], text[1], 0};
  text.remove_prefix(2);
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), axis.size);
  if (error != std::errc() || (axis.sign != '-' && axis.sign != '+') || axis.size < 0 ||
      axis.size > INT32_MAX) {
    return std::nullopt;
  }
  text.remove_prefix(size_t(end - text.data()));
  return axis;
}

// Checks the size of an attribute whose type OpenEXR knows. OpenEXR reads the value of such an
// attribute by its type and ignores the stated size. So if the size were wrong, it would read the
// rest of the header differently from this reader. Also counts the channels of a channel list.
void check_exr_attribute(HeaderReader& reader, std::string_view type, uint32_t length,
                         int64_t* channels, const std::string& place) {
  struct Fixed {
    std::string_view type;
    uint32_t length;
  };
  constexpr std::array<Fixed, 24> kFixed = {{
      {"box2f", 16},
      {"box2i", 16},
      {"chromaticities", 32},
      {"compression", 1},
      {"deepImageState", 1},
      {"double", 8},
      {"envmap", 1},
      {"float", 4},
      {"int", 4},
      {"keycode", 28},
      {"lineOrder", 1},
      {"m33d", 72},
      {"m33f", 36},
      {"m44d", 128},
      {"m44f", 64},
      {"rational", 8},
      {"tiledesc", 9},
      {"timecode", 8},
      {"v2d", 16},
      {"v2f", 8},
      {"v2i", 8},
      {"v3d", 24},
      {"v3f", 12},
      {"v3i", 12},
  }};
  const uint64_t end = reader.offset() + length;
  bool is_valid = true;
  if (type == "chlist") {
    while (!reader.until('\0').empty()) {
      reader.skip(16);
      if (++*channels > kMaxChannels) {
        throw InputError(place, "the image is not a flat picture with 1 to {} channels",
                         kMaxChannels);
      }
    }
    is_valid = reader.offset() == end;
  } else if (type == "stringvector") {
    while (reader.offset() < end) reader.skip(reader.word());
    is_valid = reader.offset() == end;
  } else if (type == "preview") {
    const double width = reader.word(), height = reader.word();
    is_valid = length == 8 + 4 * width * height;
  } else if (const auto known = std::ranges::find(kFixed, type, &Fixed::type);
             known != kFixed.end()) {
    is_valid = length == known->length;
  }
  if (is_valid) return;
  throw InputError(place, "cannot decode the image: the EXR header has an attribute of type " +
                              std::string(type) + " with the wrong size");
}

// Returns the number of rows per block. The table is in ImfCompression.h's order: none, RLE, ZIPS,
// ZIP, PIZ, PXR24, B44, B44A, DWAA, DWAB.
uint64_t rows_per_block(uint8_t compression) {
  constexpr std::array<uint64_t, 10> kRows = {1, 1, 1, 16, 32, 16, 32, 32, 32, 256};
  return compression < kRows.size() ? kRows[compression] : 256;
}

}  // namespace

[[noreturn]] void throw_truncated(const char* format, const std::string& place) {
  throw InputError(place, "cannot decode the image: the {} is truncated", format);
}

void check_pixels_fit(const ImageHeader& header, double needed, uint64_t bytes,
                      const std::string& place) {
  if (needed <= double(bytes)) return;
  throw InputError(place, "cannot decode the image: {} x {} pixels do not fit into {} bytes",
                   header.width, header.height, bytes);
}

void check_pixels_plausible(const ImageHeader& header, uint64_t bytes, const std::string& place) {
  constexpr int64_t kFreePixels = int64_t(1) << 26, kPixelsPerByte = 16384;
  const double pixels = double(header.width) * double(header.height);
  check_pixels_fit(header, (pixels - double(kFreePixels)) / double(kPixelsPerByte), bytes, place);
}

void check_tile(const ImageHeader& header, int64_t width, int64_t height,
                const std::string& place) {
  if (width <= std::max(header.width, kMaxTileSide) &&
      height <= std::max(header.height, kMaxTileSide)) {
    return;
  }
  throw InputError(place, "cannot decode the image: its tiles of {} x {} are larger than the image",
                   width, height);
}

// The format is that of "OpenEXR File Layout": magic number, version and flags, then attributes
// (name, type, size, value) up to an empty name. A multi-part file has one header per part and ends
// the list of headers with an empty one.
ImageHeader read_exr_header(const ByteSource& source, const std::string& place) {
  constexpr uint32_t kTiled = 0x200, kDeep = 0x800, kMultiPart = 0x1000;
  HeaderReader reader(source, kMaxExrHeaderBytes, "EXR", place);
  reader.skip(4);
  const uint32_t flags = reader.word();
  if (flags & kDeep) throw InputError(place, "deep EXR is not supported; flatten it");
  ImageHeader header;
  int all_attributes = 0;
  while (true) {
    int64_t width = 0, height = 0, tile_width = 0, tile_height = 0, channels = 0;
    uint8_t compression = 0, levels = 0;
    std::string part_type;
    int attributes = 0;
    for (std::string name = reader.until('\0'); !name.empty(); name = reader.until('\0')) {
      if (++attributes > kMaxExrAttributes || ++all_attributes > kMaxAttributesOfAllParts) {
        throw InputError(
            place, "cannot decode the image: the EXR header has more than {} attributes",
            attributes > kMaxExrAttributes ? kMaxExrAttributes : kMaxAttributesOfAllParts);
      }
      const std::string type = reader.until('\0');
      const uint32_t length = reader.word();
      const uint64_t value = reader.offset(), next = value + length;
      if (next > source.size) throw_truncated("EXR", place);
      check_exr_attribute(reader, type, length, &channels, place);
      reader.seek(value);
      if (name == "dataWindow" && length == 16) {
        const auto x0 = int32_t(reader.word()), y0 = int32_t(reader.word());
        const auto x1 = int32_t(reader.word()), y1 = int32_t(reader.word());
        width = int64_t(x1) - x0 + 1;
        height = int64_t(y1) - y0 + 1;
      } else if (name == "compression" && length == 1) {
        compression = reader.byte();
      } else if (name == "tiles" && length == 9) {
        tile_width = reader.word();
        tile_height = reader.word();
        levels = reader.byte() & 0xf;
      } else if (name == "type" && type == "string") {
        for (uint32_t i = 0; i < length; ++i) part_type += char(reader.byte());
      }
      reader.seek(next);
    }
    if (attributes == 0 && (flags & kMultiPart)) break;
    // A part in rows may state tiles, which readers ignore.
    const bool is_tiled = flags & kMultiPart ? part_type == "tiledimage" : (flags & kTiled) != 0;
    if (!is_tiled) tile_width = tile_height = 0;
    if (width < 1 || height < 1)
      throw InputError(place, "the image is empty ({} x {})", width, height);
    // Each tile has eight bytes in the offset table and at least eight bytes elsewhere. In an image
    // without tiles, the same holds for each block of at most 256 rows.
    const int64_t across = tile_width > 0 ? (width + tile_width - 1) / tile_width : 1;
    const int64_t down = (height + (tile_height > 0 ? tile_height : 256) - 1) /
                         (tile_height > 0 ? tile_height : 256);
    ImageHeader part;
    part.width = width;
    part.height = height;
    check_pixels_fit(part, 16.0 * double(across) * double(down), source.size, place);
    check_tile(part, tile_width, tile_height, place);
    if (header.width == 0) header = part;
    // The factor 2 counts both decoded and encoded pixels. Decoders read all channels, even
    // unwanted ones.
    const uint64_t rows = rows_per_block(compression);
    const uint64_t pixels =
        is_tiled ? uint64_t(tile_width) * uint64_t(tile_height) : uint64_t(width) * rows;
    const uint64_t all_levels = levels == 0 ? 1 : levels == 1 ? 2 : 4;  // mipmaps add a third
    const uint64_t blocks =
        is_tiled ? uint64_t(across) * uint64_t(down) * all_levels : uint64_t(height) / rows + 1;
    // Parts of other sizes are not decoded. Their sizes are not limited, so the product could
    // overflow.
    if (width == header.width && height == header.height)
      header.tile_bytes += 2 * pixels * uint64_t(channels) * sizeof(float);
    header.tile_bytes +=
        kExrEntryBytes * (uint64_t(attributes) + uint64_t(channels)) + kExrOffsetBytes * blocks;
    header.rows_per_block = std::max(header.rows_per_block, int(rows));
    if (!(flags & kMultiPart)) break;
  }
  header.tile_bytes += reader.offset();
  return header;
}

// The format is that of G. Ward, "Real Pixels" (Graphics Gems II, 1991): lines of text, an empty
// line, the resolution.
ImageHeader read_hdr_header(const ByteSource& source, const std::string& place) {
  HeaderReader reader(source, kMaxHdrHeaderBytes, "HDR", place);
  for (std::string line = reader.until('\n'); !line.empty(); line = reader.until('\n')) {
    if (line.starts_with("FORMAT=") && line.find("rgbe") == std::string::npos) {
      throw InputError(
          place, "cannot decode the image: the pixels of the HDR file are not stored as RGBE");
    }
  }
  const std::string line = reader.until('\n');
  std::string_view text = line;
  const std::optional<HdrAxis> first = read_hdr_axis(text), second = read_hdr_axis(text);
  const bool rows = first && second && first->letter == 'Y' && second->letter == 'X';
  const bool columns = first && second && first->letter == 'X' && second->letter == 'Y';
  if (!rows && !columns) {
    throw InputError(place, "cannot decode the image: the HDR has no resolution line");
  }
  ImageHeader header;
  header.width = (rows ? second : first)->size;
  header.height = (rows ? first : second)->size;
  const bool mirrored = second->sign == '-', upwards = first->sign == '+';
  header.orientation = columns ? 5 : upwards ? (mirrored ? 3 : 4) : (mirrored ? 2 : 1);
  header.pixel_offset = reader.offset();
  // A row has at least four bytes per pixel, or four bytes and then two for each run of up to 127
  // pixels in each of the four channels.
  const int64_t row = std::min(4 * header.width, 4 + 8 * ((header.width + 126) / 127));
  check_pixels_fit(header, double(row) * double(header.height), source.size, place);
  return header;
}

}  // namespace emberline
