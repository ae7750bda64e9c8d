// The image viewer tev's network protocol: its addresses and the packets that a render needs.
//
// Laid out as tev itself reads them (github.com/Tom94/tev: README, "Inter-Process Communication";
// class IpcPacket in include/tev/Ipc.h and src/Ipc.cpp), over TCP, in one direction:
//
//   packet        uint32 length of the whole packet, these four bytes included; uint8 type; payload
//   CreateImage   type 4: bool grab focus; string name; int32 width, height, channel count; a
//                 string for each channel
//   UpdateImage   type 6, its third version, with strides (tev from March 2021 on): bool grab
//   focus;
//                 string name; int32 channel count; a string for each; int32 x, y, width, height;
//                 an int64 offset for each channel; an int64 stride for each; floats
//
// Integers and floats are little-endian, strings end with a zero, a bool is a byte. The value of
// channel c of the rectangle's pixel i, rows from the top, is floats[offset[c] + i * stride[c]].
//
// Plain functions: any thread.
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
  static constexpr uint16_t kDefaultPort = 14158;  // the one that tev listens on unless told

  std::string host;  // a name or an address; IPv6 without its brackets
  uint16_t port = kDefaultPort;

  std::string url() const;  // tev://HOST:PORT
  bool operator==(const TevAddress&) const = default;
};

// Whether an option's value means a viewer, well formed or not: it begins with "tev:".
bool is_tev_url(std::string_view text);

// tev://HOST[:PORT], HOST a name, an IPv4 address or an IPv6 address in brackets. Throws UsageError
// that names this form.
TevAddress parse_tev_url(std::string_view url);

// A black image with the channels R G B A, shown at once. One of the same name is replaced. `name`
// has no zero in it.
std::vector<std::byte> tev_create_image(std::string_view name, int width, int height);

// New values for `rect` of an image made so. `rgba`: R G B A of every pixel of `layout`, in which
// `rect` lies, interleaved, rows from its top. The packet has to be shorter than 4 GiB.
std::vector<std::byte> tev_update_image(std::string_view name, const Rect& rect,
                                        std::span<const float> rgba, const Rect& layout);

}  // namespace emberline
