// Inspects encoded images before they are decoded: finds the format and the size, and makes a
// reduced stream for the decoder. Decoders are large programs and the input is untrusted. So they
// get only what the pixels need: no colour profiles (glTF 2.0 section 3.8.3 says to ignore them),
// EXIF, XMP, IPTC, comments or thumbnails, nothing after the image, and no size that is too large
// for the number of bytes. All functions throw InputError at `place`.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/image/byte_cursor.h"

namespace emberline {

enum class ImageFormat : uint8_t { kNone, kPng, kJpeg, kWebp, kExr, kHdr, kTiff, kKtx2 };

// Detects the format from the first 12 bytes, since suffixes and media types are less reliable.
ImageFormat sniff_image_format(std::span<const uint8_t> bytes);
std::string_view format_name(ImageFormat format);  // "PNG"

// Values from an image's header, which is read before decoding.
struct ImageHeader {
  int64_t width = 0, height = 0;
  // Upper bound on the decoder's memory per pixel, in addition to the result.
  int decoder_bytes_per_pixel = 0;
  // EXR: memory of one decoding thread (headers, a tile of each part). KTX 2: decoder's memory.
  uint64_t tile_bytes = 0;
  int rows_per_block = 1;  // EXR without tiles: the number of rows that are compressed together
  // The orientation, as in TIFF and EXIF. 1: rows from the top; 2: mirrored; 3: rotated by 180
  // degrees; 4: rows from the bottom; 5 to 8: stored in columns instead of rows.
  int orientation = 1;
  uint64_t pixel_offset = 0;  // HDR: offset of the rows
};

// For PNG, JPEG and WebP: the header, and the stream reduced to what the pixels need.
struct CleanImage {
  ImageHeader header;
  std::vector<uint8_t> bytes;
  bool truncated = false;  // whether a JPEG has no end; other truncated files are rejected
};
CleanImage clean_image(ImageFormat format, std::span<const uint8_t> bytes,
                       const std::string& place);

// Removes profiles and other metadata from the first directory of a TIFF, in place.
void clean_tiff(std::span<uint8_t> bytes, const std::string& place);

// EXR and HDR are decoded from the original bytes. Their headers contain nothing that harms the
// decoders, and these functions check the sizes. Deep EXR files are rejected.
ImageHeader read_exr_header(const ByteSource& source, const std::string& place);
ImageHeader read_hdr_header(const ByteSource& source, const std::string& place);

// Checks that these readers share with io/image/ktx2. No other code uses them.
[[noreturn]] void throw_truncated(const char* format, const std::string& place);

// Throws if the encoded pixels need at least `needed` bytes but the file has only `bytes`. This
// guards against headers that state a large size for little data.
void check_pixels_fit(const ImageHeader& header, double needed, uint64_t bytes,
                      const std::string& place);

// Like check_pixels_fit(), for formats without a maximum compression ratio (lossless WebP, TIFF,
// KTX 2). In these, an image of a single colour takes few bytes whatever its size. Accepts up to
// 8192 x 8192 pixels at any ratio. Larger images need a plausible ratio.
void check_pixels_plausible(const ImageHeader& header, uint64_t bytes, const std::string& place);

// Throws for tiles that are wider (or higher) than 4096 pixels and also wider (or higher) than the
// image, since a tile is always decoded as a whole.
void check_tile(const ImageHeader& header, int64_t width, int64_t height, const std::string& place);

}  // namespace emberline
