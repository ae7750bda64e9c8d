// The network protocol of the image viewer tev: its addresses and the packets that a render needs.
//
// This follows tev's own reader (github.com/Tom94/tev: README, "Inter-Process Communication"; class
// IpcPacket in include/tev/Ipc.h and src/Ipc.cpp). Packets are sent over TCP, in one direction:
//
// clang-format off
//   packet        uint32 length of the whole packet, including itself; uint8 type; payload
//   CreateImage   type 4: bool grab focus; string name; int32 width, height, channel count; a
//                 string for each channel
//   UpdateImage   type 6, third version, with strides (tev since March 2021): bool grab focus;
//                 string name; int32 channel count; a string for each; int32 x, y, width, height;
//                 an int64 offset for each channel; an int64 stride for each; floats
// clang-format on
//
// Integers and floats are little-endian, strings end with a zero byte, and a bool is one byte.
// Pixels of the rectangle are numbered row by row from the top. Channel c of pixel i is
// floats[offset[c] + i * stride[c]].
//
// All functions are thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/core/rect.h"

namespace emberline {

struct TevAddress {
  static constexpr uint16_t kDefaultPort = 14158;  // tev's default

  std::string host;  // a name or an address; IPv6 addresses without their brackets
  uint16_t port = kDefaultPort;

  std::string url() const;  // tev://HOST:PORT
  bool operator==(const TevAddress&) const = default;
};

// Whether an option's value begins with "tev:" and is thus meant as a viewer's address, even if it
// is not a valid one.
bool is_tev_url(std::string_view text);

// Parses tev://HOST[:PORT]. HOST is a name, an IPv4 address, or an IPv6 address in brackets. Throws
// UsageError, whose message shows this form.
TevAddress parse_tev_url(std::string_view url);

// Returns the packet that creates a black image with the channels R G B A and shows it at once. The
// viewer replaces an image of the same name. `name` must not contain a zero byte.
std::vector<std::byte> tev_create_image(std::string_view name, int width, int height);

// Returns the packet that updates `rect` of an image made by tev_create_image(). `rgba` holds
// interleaved RGBA for every pixel of `layout`, with rows from the top. `layout` must contain
// `rect`. The packet must be shorter than 4 GiB.
std::vector<std::byte> tev_update_image(std::string_view name, const Rect& rect,
                                        std::span<const float> rgba, const Rect& layout);

}  // namespace emberline
