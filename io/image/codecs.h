// Codecs for PNG (through libpng), JPEG (through libjpeg) and Radiance HDR. With these and
// io/exr/decoder.h, most runs do not have to load image_library().
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "io/image/encoded_image.h"
#include "io/image/library.h"

namespace emberline {

// Like ImageLibrary::open(), but each read must ask for all channels, and rows must be read in
// order. Palettes, depths below 8 bits and a transparent colour (`tRNS`) are expanded. CMYK is
// converted to RGB. On failure, returns null and sets `error`. `bytes` must outlive the decoder.
std::unique_ptr<ImageDecoder> open_png(std::span<const uint8_t> bytes, std::string& error);
std::unique_ptr<ImageDecoder> open_jpeg(std::span<const uint8_t> bytes, std::string& error);

// Decodes Radiance's picture format (.hdr): three mantissa bytes and an exponent per pixel, in
// plain or run-length encoded rows (G. Ward, "Real Pixels", Graphics Gems II, 1991). With this
// decoder, OpenImageIO need not be loaded (0.3 s and 120 MB). Ignores the header's exposure and
// gamma, as OpenImageIO does. `header` must come from read_hdr_header(), and its size must have
// been checked. `source` must outlive the decoder.
std::unique_ptr<ImageDecoder> open_hdr(const ByteSource& source, const ImageHeader& header);

// These encode a picture as a complete file in memory. They return an empty string, or the error.
// JPEG drops alpha, and uses quality 95 without chroma subsampling.
std::string encode_png(const ByteImage& picture, std::vector<unsigned char>& encoded);
std::string encode_jpeg(const ByteImage& picture, std::vector<unsigned char>& encoded);

}  // namespace emberline
