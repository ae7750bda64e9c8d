// PNG through libpng, JPEG through libjpeg, and Radiance's HDR. Nearly every texture, picture and
// environment map is one of the three, and with them most runs need no image_library().
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "io/image/encoded_image.h"
#include "io/image/library.h"

namespace emberline {

// As ImageLibrary::open, but for all channels and all rows, in order. Palettes, fewer than 8 bits
// and a transparent colour (`tRNS`) are expanded; CMYK becomes RGB. Null: `error` says why. `bytes`
// outlive the decoder.
std::unique_ptr<ImageDecoder> open_png(std::span<const uint8_t> bytes, std::string& error);
std::unique_ptr<ImageDecoder> open_jpeg(std::span<const uint8_t> bytes, std::string& error);

// Radiance's picture format (.hdr): three bytes and an exponent for each pixel, rows flat or as
// runs (G. Ward, "Real Pixels", Graphics Gems II, 1991). To read them so spares the run
// OpenImageIO: 0.3 s and 120 MB. Exposure and gamma of the header are ignored, as OpenImageIO does.
// `header`: what read_hdr_header() gave, with sides that were checked. `source` outlives the
// decoder.
std::unique_ptr<ImageDecoder> open_hdr(const ByteSource& source, const ImageHeader& header);

// The bytes of a file. Nothing, or why it failed. JPEG drops alpha, at quality 95 without chroma
// subsampling.
std::string encode_png(const ByteImage& picture, std::vector<unsigned char>& encoded);
std::string encode_jpeg(const ByteImage& picture, std::vector<unsigned char>& encoded);

}  // namespace emberline
