// Decodes EXR files through OpenEXR.
#pragma once

#include <memory>
#include <string>

#include "io/image/encoded_image.h"
#include "io/image/library.h"

namespace emberline {

// Opens an EXR of any compression. Parts that cover the same pixels as the first part are joined
// with it into one image. Channels are in the order of their layers; within a layer, colours come
// first. `header` must come from read_exr_header(), and its size must have been checked. Reads use
// up to `threads` threads, each of which needs header.tile_bytes of memory. UINT channels arrive as
// floats with the same value, if it is below 2^24. On failure, returns null and sets `error`.
// `source` must outlive the decoder.
std::unique_ptr<ImageDecoder> open_exr(const ByteSource& source, const ImageHeader& header,
                                       int threads, std::string& error);

}  // namespace emberline
