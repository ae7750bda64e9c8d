// PNG through libpng, JPEG through libjpeg, and Radiance HDR. These cover nearly all textures,
// pictures and environment maps, so most runs need not load image_library().
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "io/image/encoded_image.h"
#include "io/image/library.h"

namespace emberline {

// Like ImageLibrary::open, but reads all channels and all rows, in order. Palettes, depths below 8
// bits and a transparent colour (`tRNS`) are expanded; CMYK is converted to RGB. Returns null on
// failure and sets `error`. `bytes` must outlive the decoder.
std::unique_ptr<ImageDecoder> open_png(std::span<const uint8_t> bytes, std::string& error);
std::unique_ptr<ImageDecoder> open_jpeg(std::span<const uint8_t> bytes, std::string& error);

// Radiance's picture format (.hdr): three mantissa bytes and an exponent per pixel, rows flat or
// run-length encoded (G. Ward, "Real Pixels", Graphics Gems II, 1991). Avoids loading OpenImageIO
// (0.3 s and 120 MB). Ignores the header's exposure and gamma, as OpenImageIO does. `header` comes
// from read_hdr_header(), with its size checked. `source` must outlive the decoder.
std::unique_ptr<ImageDecoder> open_hdr(const ByteSource& source, const ImageHeader& header);

// Encode to the bytes of a file. Return an empty string or the error. JPEG drops alpha and uses
// quality 95 without chroma subsampling.
std::string encode_png(const ByteImage& picture, std::vector<unsigned char>& encoded);
std::string encode_jpeg(const ByteImage& picture, std::vector<unsigned char>& encoded);

}  // namespace emberline
