// What the readers of headers and of streams check alike. For io/image/encoded_*.cpp and
// io/image/ktx2 alone.
#pragma once

#include <string>

#include "io/image/encoded_image.h"

namespace emberline {

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
