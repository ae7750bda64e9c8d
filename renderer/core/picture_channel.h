// A channel of a film, a frame or an EXR file.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace emberline {

enum class ChannelType : uint8_t { kFloat, kUint, kHalf };

struct PictureChannel {
  std::string name;  // such as "R", "albedo.G" or "samples"
  ChannelType type = ChannelType::kFloat;
};

inline std::vector<std::string> names_of(std::span<const PictureChannel> channels) {
  std::vector<std::string> names;
  for (const PictureChannel& channel : channels) names.push_back(channel.name);
  return names;
}

}  // namespace emberline
