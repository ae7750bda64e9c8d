// KTX 2 pictures as glTF has them (KHR_texture_basisu): ETC1S in BasisLZ, UASTC plain or packed by
// Zstandard. Level 0 is decoded; of the others only the sizes are looked at.
//
// Written from the specifications: the formats are small, and decoders of them come as parts of
// transcoders for GPUs.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "io/image/encoded_image.h"
#include "io/image/library.h"

namespace emberline {

// An attribute of the decoder's: "sRGB" or "linear".
inline constexpr const char* kTransferAttribute = "ktx2:transfer";

// Checks the container. Throws InputError at `place` for what is damaged or of another kind.
ImageHeader read_ktx2_header(std::span<const uint8_t> bytes, const std::string& place);

// Of bytes that read_ktx2_header took, and that outlive the decoder. Its rows are read from the
// first on, all channels, as bytes: red, red-green-blue, or these and alpha, not multiplied.
// Opening and reading throw InputError where the data are damaged.
std::unique_ptr<ImageDecoder> open_ktx2(std::span<const uint8_t> bytes, const std::string& place);

}  // namespace emberline
