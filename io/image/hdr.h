// Radiance's picture format (.hdr): three bytes and an exponent for each pixel, rows flat or as
// runs (G. Ward, "Real Pixels", Graphics Gems II, 1991). Most environment maps are such files, and
// to read them so spares the run OpenImageIO: 0.3 s and 120 MB.
//
// Exposure and gamma of the header are ignored, as OpenImageIO does.
#pragma once

#include <memory>

#include "io/image/encoded_image.h"
#include "io/image/library.h"

namespace emberline {

// As ImageLibrary::open, but for all rows, in order. `header`: what read_hdr_header() gave, with
// sides that were checked. `source` outlives the decoder.
std::unique_ptr<ImageDecoder> open_hdr(const ByteSource& source, const ImageHeader& header);

}  // namespace emberline
