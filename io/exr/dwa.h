// Implements ImageLibrary::encode_dwa().
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "io/image/library.h"

namespace emberline {

// Encodes a tile as DWAA, or as DWAB if `wide`. Throws OpenEXR's exceptions.
void encode_dwa_tile(int width, int height, std::span<const EncodedPlane> planes, bool wide,
                     std::vector<uint8_t>& code);

}  // namespace emberline
