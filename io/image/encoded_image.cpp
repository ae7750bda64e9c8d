#include "io/image/encoded_image.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "io/files/byte_order.h"
#include "renderer/core/errors.h"

namespace emberline {
namespace {

using Bytes = std::span<const uint8_t>;

// DEFLATE's best compression ratio. Two bits can encode 258 bytes (RFC 1951; zlib's technical
// notes).
constexpr int kDeflateRatio = 1032;
// Every scan of a progressive JPEG visits all pixels. Encoders write about ten scans.
constexpr int kMaxScans = 500, kUncheckedScans = 20;
constexpr int64_t kMaxScannedBlocks = int64_t(1) << 26;

bool starts_with(Bytes bytes, std::string_view magic, size_t offset = 0) {
  return bytes.size() >= offset + magic.size() &&
         std::memcmp(bytes.data() + offset, magic.data(), magic.size()) == 0;
}

void append(std::vector<uint8_t>& out, Bytes bytes) {
  const size_t end = out.size();
  out.resize(end + bytes.size());
  std::memcpy(out.data() + end, bytes.data(), bytes.size());
}

// Keeps only the chunks that affect the samples. A chunk has a length, a type, data and a CRC (PNG
// specification, 5.3).
CleanImage clean_png(Bytes bytes, const std::string& place) {
  constexpr std::array<std::string_view, 5> kKeptChunks = {"IHDR", "PLTE", "tRNS", "IDAT", "IEND"};
  constexpr std::array<int, 7> kSamples = {1, 0, 3, 1, 2, 0, 4};  // by colour type
  CleanImage clean;
  clean.bytes.reserve(bytes.size());
  append(clean.bytes, bytes.first(8));
  int64_t compressed = 0, row_bits = 0;
  for (size_t offset = 8; bytes.size() - offset >= 12;) {
    const uint64_t length = big_endian(bytes, offset, 4);
    if (length > bytes.size() - offset - 12) break;
    const Bytes chunk = bytes.subspan(offset, size_t(length) + 12);
    offset += chunk.size();
    const auto is = [&](std::string_view type) { return starts_with(chunk, type, 4); };
    if (!std::ranges::any_of(kKeptChunks, is)) continue;
    append(clean.bytes, chunk);
    if (is("IHDR") && length >= 13 && row_bits == 0) {
      const int depth = chunk[16], colour = chunk[17];
      const bool interlaced = chunk[20] != 0;
      clean.header.width = big_endian(chunk, 8, 4);
      clean.header.height = big_endian(chunk, 12, 4);
      row_bits = clean.header.width * depth * (colour < 7 ? kSamples[size_t(colour)] : 4);
      // An interlaced image is decoded as a whole and then copied to the result. The decoded image
      // has up to 4 x 16 bits per pixel.
      clean.header.decoder_bytes_per_pixel = interlaced ? 8 : 0;
    }
    if (is("IDAT")) compressed += int64_t(length);
    if (!is("IEND")) continue;
    const int64_t row = row_bits / 8 + 1;
    check_pixels_fit(clean.header, double(row) * double(clean.header.height) / kDeflateRatio,
                     uint64_t(compressed) + kDeflateRatio, place);
    return clean;
  }
  throw_truncated("PNG", place);
}

// Returns the end of entropy-coded data: the next marker that is not a restart (ITU-T T.81,
// B.1.1.2).
size_t end_of_scan(Bytes bytes, size_t offset) {
  while (offset + 1 < bytes.size()) {
    const void* found = std::memchr(&bytes[offset], 0xff, bytes.size() - 1 - offset);
    if (!found) break;
    offset = size_t(static_cast<const uint8_t*>(found) - bytes.data());
    const uint8_t next = bytes[offset + 1];
    if (next != 0x00 && next != 0xff && (next < 0xd0 || next > 0xd7)) return offset;
    offset += next == 0xff ? 1 : 2;
  }
  return bytes.size();
}

// Whether the marker begins a frame of any kind (baseline, extended or progressive, Huffman or
// arithmetic). These are C0 to CF, except the markers of tables and extensions.
bool is_frame_marker(uint8_t marker) {
  return marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
}

// Reads a frame header: the frame's size, its number of components, and the minimum number of bits
// that all its blocks take together.
void read_frame_header(Bytes segment, ImageHeader* header, size_t* components_out,
                       int64_t* min_bits) {
  if (segment.size() < 10) return;
  const size_t components = *components_out = segment[9];
  header->height = big_endian(segment, 5, 2);
  header->width = big_endian(segment, 7, 2);
  int64_t across = 8, down = 8;  // size of a minimum coded unit, which has at least one bit
  for (size_t c = 0; c < components && 12 + 3 * c <= segment.size(); ++c) {
    across = std::max<int64_t>(across, 8 * (segment[11 + 3 * c] >> 4));
    down = std::max<int64_t>(down, 8 * (segment[11 + 3 * c] & 15));
  }
  *min_bits = (header->width / across) * (header->height / down);
  // A progressive decoder keeps all coefficients: 16 bits per pixel and component.
  const uint8_t marker = segment[1];
  const bool progressive = marker == 0xc2 || marker == 0xc6 || marker == 0xca || marker == 0xce;
  header->decoder_bytes_per_pixel = progressive ? 2 * int(components) : 0;
}

CleanImage clean_jpeg(Bytes bytes, const std::string& place) {
  CleanImage clean;
  clean.bytes.reserve(bytes.size());
  append(clean.bytes, bytes.first(2));
  int64_t min_bits = 0;
  size_t components = 0;
  int scans = 0;
  size_t offset = 2;
  clean.truncated = true;
  while (offset + 4 <= bytes.size() || (offset + 2 <= bytes.size() && bytes[offset + 1] == 0xd9)) {
    if (bytes[offset] != 0xff) {
      ++offset;  // decoders skip stray bytes between segments
      continue;
    }
    const uint8_t marker = bytes[offset + 1];
    if (marker == 0xff || marker == 0x00 || marker == 0x01 || (marker >= 0xd0 && marker <= 0xd8)) {
      offset += marker == 0xff ? 1 : 2;  // skips a fill byte, or a marker without a segment
      continue;
    }
    if (marker == 0xd9) {
      append(clean.bytes, bytes.subspan(offset, 2));
      clean.truncated = false;
      break;
    }
    const size_t length = big_endian(bytes, offset + 2, 2) + size_t(2);
    if (length < 4 || length > bytes.size() - offset) break;
    Bytes segment = bytes.subspan(offset, length);
    offset += length;
    const bool application = marker >= 0xe0 && marker <= 0xef;
    const bool kept =
        application ? (marker == 0xe0 && starts_with(segment, std::string_view("JFIF\0", 5), 4)) ||
                          (marker == 0xee && starts_with(segment, "Adobe", 4))
                    : marker < 0xf0;  // drops JPG extensions and comments
    if (!kept) continue;
    if (is_frame_marker(marker) && clean.header.width == 0) {
      read_frame_header(segment, &clean.header, &components, &min_bits);
    }
    append(clean.bytes, segment);
    if (marker != 0xda) continue;
    // Decoders also keep all coefficients if scans are not interleaved.
    if (segment.size() > 4 && segment[4] < components) {
      clean.header.decoder_bytes_per_pixel = 2 * int(components);
    }
    const int64_t blocks = clean.header.width * clean.header.height / 64;
    if (++scans > kMaxScans || (scans > kUncheckedScans && scans * blocks > kMaxScannedBlocks)) {
      throw InputError(place, "cannot decode the image: the JPEG has more than {} scans",
                       scans - 1);
    }
    const size_t end = end_of_scan(bytes, offset);
    append(clean.bytes, bytes.subspan(offset, end - offset));
    offset = end;
  }
  if (scans == 0) throw_truncated("JPEG", place);
  check_pixels_fit(clean.header, double(min_bits) / 8, bytes.size(), place);
  if (clean.truncated) append(clean.bytes, std::array<uint8_t, 2>{0xff, 0xd9});
  return clean;
}

// Reads RIFF chunks (RFC 9649, 2.3). A still image is a VP8 or VP8L chunk. With alpha, VP8X and
// ALPH come before it.
CleanImage clean_webp(Bytes bytes, const std::string& place) {
  constexpr std::array<std::string_view, 4> kKeptChunks = {"VP8X", "ALPH", "VP8 ", "VP8L"};
  constexpr uint8_t kAlphaFlag = 0x10, kAnimationFlag = 0x02;
  CleanImage clean;
  clean.bytes.reserve(bytes.size());
  append(clean.bytes, bytes.first(12));
  // In addition to the result, the reader keeps the decoded picture and, for VP8L, another copy of
  // that picture.
  clean.header.decoder_bytes_per_pixel = 8;
  const uint64_t stated_size = uint64_t(little_endian(bytes, 4, 4)) + 8;
  if (stated_size > bytes.size()) throw_truncated("WebP", place);
  bool has_picture = false;
  for (size_t offset = 12; stated_size >= offset + 8 && !has_picture;) {
    const uint64_t length = little_endian(bytes, offset + 4, 4), padded = length + (length & 1);
    if (length > stated_size - offset - 8) throw_truncated("WebP", place);
    const size_t size = size_t(std::min(padded + 8, stated_size - offset));
    const Bytes chunk = bytes.subspan(offset, size);
    offset += size;
    const auto is = [&](std::string_view type) { return starts_with(chunk, type); };
    if (!std::ranges::any_of(kKeptChunks, is)) continue;
    const size_t at = clean.bytes.size();
    append(clean.bytes, chunk);
    if (is("VP8X") && length >= 10) {
      if (chunk[8] & kAnimationFlag) {
        throw InputError(place, "animated WebP is not supported; save a single frame");
      }
      clean.bytes[at + 8] = uint8_t(chunk[8] & kAlphaFlag);  // keeps only the alpha flag
      clean.header.width = int64_t(little_endian(chunk, 12, 3)) + 1;
      clean.header.height = int64_t(little_endian(chunk, 15, 3)) + 1;
    } else if (is("VP8 ") && length >= 10) {  // RFC 6386, section 9.1
      clean.header.width = little_endian(chunk, 14, 2) & 0x3fff;
      clean.header.height = little_endian(chunk, 16, 2) & 0x3fff;
      has_picture = true;
    } else if (is("VP8L") && length >= 5) {  // RFC 9649, section 3.4
      const uint32_t bits = little_endian(chunk, 9, 4);
      clean.header.width = int64_t(bits & 0x3fff) + 1;
      clean.header.height = int64_t(bits >> 14 & 0x3fff) + 1;
      has_picture = true;
    }
  }
  if (!has_picture) throw_truncated("WebP", place);
  check_pixels_plausible(clean.header, bytes.size(), place);
  const uint32_t size = uint32_t(clean.bytes.size() - 8);
  for (size_t i = 0; i < 4; ++i) clean.bytes[4 + i] = uint8_t(size >> (8 * i));
  return clean;
}

}  // namespace

ImageFormat sniff_image_format(Bytes bytes) {
  if (starts_with(bytes, "\x89PNG\r\n\x1a\n")) return ImageFormat::kPng;
  if (starts_with(bytes, "\xff\xd8\xff")) return ImageFormat::kJpeg;
  if (starts_with(bytes, "RIFF") && starts_with(bytes, "WEBP", 8)) return ImageFormat::kWebp;
  if (starts_with(bytes, "\x76\x2f\x31\x01")) return ImageFormat::kExr;
  if (starts_with(bytes, "#?")) return ImageFormat::kHdr;
  if (starts_with(bytes, "\xabKTX 20\xbb\r\n\x1a\n")) return ImageFormat::kKtx2;
  if (starts_with(bytes, std::string_view("II*\0", 4)) ||
      starts_with(bytes, std::string_view("MM\0*", 4))) {
    return ImageFormat::kTiff;
  }
  return ImageFormat::kNone;
}

std::string_view format_name(ImageFormat format) {
  constexpr std::array<std::string_view, 8> kNames = {"none", "PNG", "JPEG", "WebP",
                                                      "EXR",  "HDR", "TIFF", "KTX 2"};
  return kNames[size_t(format)];
}

CleanImage clean_image(ImageFormat format, Bytes bytes, const std::string& place) {
  if (format == ImageFormat::kPng) return clean_png(bytes, place);
  if (format == ImageFormat::kJpeg) return clean_jpeg(bytes, place);
  return clean_webp(bytes, place);
}

// In TIFF 6.0, section 2, a directory has entries of 12 bytes in ascending order, and then the
// offset of the next directory.
void clean_tiff(std::span<uint8_t> bytes, const std::string& place) {
  constexpr std::array<uint32_t, 7> kDroppedTags = {
      700,    // XMP
      33723,  // IPTC
      34377,  // Photoshop's
      34665,  // EXIF
      34675,  // ICC profile
      34853,  // GPS
      40965,  // Interoperability
  };
  constexpr size_t kEntry = 12;
  if (bytes.size() < 8) throw_truncated("TIFF", place);
  const bool is_big_endian = bytes[0] == 'M';
  const auto read = [&](size_t offset, size_t number_bytes) {
    return is_big_endian ? big_endian(bytes, offset, number_bytes)
                         : little_endian(bytes, offset, number_bytes);
  };
  const size_t directory = read(4, 4);
  if (directory > bytes.size() - 2) throw_truncated("TIFF", place);
  const size_t count = read(directory, 2);
  if ((bytes.size() - directory - 2) / kEntry < count) throw_truncated("TIFF", place);
  uint8_t* const entries = &bytes[directory + 2];
  ImageHeader header;
  int64_t tile_width = 0, tile_height = 0;
  size_t kept = 0;
  for (size_t i = 0; i < count; ++i) {
    const size_t entry = directory + 2 + i * kEntry;
    const uint32_t tag = read(entry, 2);
    const int64_t value = read(entry + 8, read(entry + 2, 2) == 3 ? 2 : 4);
    if (tag == 256) header.width = value;
    if (tag == 257) header.height = value;
    if (tag == 322) tile_width = value;
    if (tag == 323) tile_height = value;
    if (std::ranges::find(kDroppedTags, tag) != kDroppedTags.end()) continue;
    std::memmove(entries + kept++ * kEntry, entries + i * kEntry, kEntry);
  }
  check_pixels_plausible(header, bytes.size(), place);
  check_tile(header, tile_width, tile_height, place);
  // Ends the list of directories after the first directory, since other pages are not read.
  const size_t end = directory + 2 + kept * kEntry;
  std::memset(&bytes[end], 0, std::min<size_t>(4, bytes.size() - end));
  bytes[directory] = uint8_t(is_big_endian ? kept >> 8 : kept);
  bytes[directory + 1] = uint8_t(is_big_endian ? kept : kept >> 8);
}

}  // namespace emberline
