// Encodes DWAA and DWAB tiles. OpenEXR's C interface (3.1), which the writer uses, cannot do this.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "renderer/core/picture_channel.h"

namespace emberline {

// One channel of a tile, row after row.
struct EncodedPlane {
  std::string channel;
  ChannelType type = ChannelType::kFloat;
  const uint8_t* values = nullptr;
};

// Encodes a tile as DWAA, or as DWAB if `wide`. Throws OpenEXR's exceptions.
void encode_dwa_tile(int width, int height, std::span<const EncodedPlane> planes, bool wide,
                     std::vector<uint8_t>& code);

}  // namespace emberline
