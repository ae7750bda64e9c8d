// PNG through libpng and JPEG through libjpeg. Nearly every texture and picture is one of the two,
// and with them most runs need no image_library().
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "io/image/library.h"

namespace emberline {

// As ImageLibrary::open, but for all channels and all rows, in order. Palettes, fewer than 8 bits
// and a transparent colour (`tRNS`) are expanded; CMYK becomes RGB. Null: `error` says why. `bytes`
// outlive the decoder.
std::unique_ptr<ImageDecoder> open_png(std::span<const uint8_t> bytes, std::string& error);
std::unique_ptr<ImageDecoder> open_jpeg(std::span<const uint8_t> bytes, std::string& error);

// The bytes of a file. Nothing, or why it failed. JPEG drops alpha, at quality 95 without chroma
// subsampling.
std::string encode_png(const ByteImage& picture, std::vector<unsigned char>& encoded);
std::string encode_jpeg(const ByteImage& picture, std::vector<unsigned char>& encoded);

}  // namespace emberline
