// Decodes KTX 2 images in glTF (KHR_texture_basisu): ETC1S with BasisLZ, and UASTC without
// supercompression or with Zstandard. Decodes only level 0. Of the other levels, checks only the
// sizes.
//
// We implemented this decoder from the specifications, because existing decoders come with GPU
// transcoders.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "io/image/encoded_image.h"
#include "io/image/library.h"

namespace emberline {

// The decoder's attribute that states the transfer function, "sRGB" or "linear".
inline constexpr const char* kTransferAttribute = "ktx2:transfer";

// Reads the header and checks the container. Throws InputError at `place` if it is damaged or
// unsupported.
ImageHeader read_ktx2_header(std::span<const uint8_t> bytes, const std::string& place);

// `bytes` must have passed read_ktx2_header() and must outlive the decoder. Rows must be read in
// order, with all channels, as bytes. The channels are R, RGB or RGBA, with unassociated alpha.
// Opening and reading throw InputError if the data are damaged.
std::unique_ptr<ImageDecoder> open_ktx2(std::span<const uint8_t> bytes, const std::string& place);

}  // namespace emberline
