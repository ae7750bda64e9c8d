// Encoded images before they are decoded: which format, which size, and the stream that a decoder
// gets to see. Decoders are large and meet bytes from anywhere, so they are handed as little as the
// pixels need: no colour profiles (glTF 2.0 section 3.8.3 says to ignore them), EXIF, XMP, IPTC,
// comments or thumbnails, nothing behind the image, and no announced size that the bytes cannot
// hold. All functions throw InputError at `place`.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/image/byte_cursor.h"

namespace emberline {

enum class ImageFormat : uint8_t { kNone, kPng, kJpeg, kWebp, kExr, kHdr, kTiff, kKtx2 };

// From the first 12 bytes; suffixes and media types say less: exporters get them wrong.
ImageFormat sniff_image_format(std::span<const uint8_t> bytes);
std::string_view name_of(ImageFormat format);  // "PNG"

// What the header announces, before anything is decoded.
struct ImageHeader {
  int64_t width = 0, height = 0;
  // Memory that the decoder takes for each pixel beside its result, at most.
  int decoder_bytes_per_pixel = 0;
  uint64_t tile_bytes = 0;  // and for a tile, or the rows that are coded together: an EXR's
  // As in TIFF and EXIF: 1 rows from the top, 2 mirrored, 3 turned by half, 4 rows from the bottom;
  // 5 to 8 columns instead of rows.
  int orientation = 1;
  uint64_t pixels_at = 0;  // an HDR's: where its rows begin
};

// PNG, JPEG and WebP: the size, and the same stream with what the pixels need alone.
struct CleanImage {
  ImageHeader header;
  std::vector<uint8_t> bytes;
  bool cut_short = false;  // a JPEG without an end; the others are refused
};
CleanImage clean_image(ImageFormat format, std::span<const uint8_t> bytes,
                       const std::string& place);

// TIFF: the tags of profiles and other metadata taken out of the first directory, in place.
void clean_tiff(std::span<uint8_t> bytes, const std::string& place);

// EXR and HDR are read where they lie; their headers hold nothing that decoders stumble over, but
// their sizes are checked. Deep EXR files are refused.
ImageHeader read_exr_header(const ByteSource& source, const std::string& place);
ImageHeader read_hdr_header(const ByteSource& source, const std::string& place);

// What the readers of headers and of streams check alike; for these and io/image/ktx2 alone.
[[noreturn]] void throw_truncated(const char* format, const std::string& place);

// Throws unless the pixels can be in the bytes: a header costs nothing, an image does.
void check_bears_out(const ImageHeader& header, double needed, uint64_t bytes,
                     const std::string& place);

// The same for codes without a best ratio (lossless WebP, TIFF, KTX 2): a picture of one colour
// takes some bytes at any size. Up to 8192 x 8192 such ones are taken; beyond, the ratio of no real
// picture is not believed.
void check_bears_out_any_code(const ImageHeader& header, uint64_t bytes, const std::string& place);

// A tile is decoded whole, also where the picture is smaller. Throws for larger ones than 4096.
void check_tile(const ImageHeader& header, int64_t width, int64_t height, const std::string& place);

}  // namespace emberline
