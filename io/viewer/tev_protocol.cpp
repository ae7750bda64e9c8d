#include "io/viewer/tev_protocol.h"

#include <arpa/inet.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <charconv>
#include <cstring>
#include <limits>
#include <optional>

#include "renderer/core/errors.h"
#include "renderer/core/file_suffix.h"
#include "renderer/core/shortened.h"

namespace emberline {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are sent as they lie in memory");

constexpr std::string_view kScheme = "tev://";
constexpr std::array<std::string_view, 4> kChannels = {"R", "G", "B", "A"};

enum class PacketType : uint8_t { kCreateImage = 4, kUpdateImageV3 = 6 };

bool begins_with(std::string_view text, std::string_view lower) {
  return lower_case(std::string(text.substr(0, lower.size()))) == lower;
}

std::optional<uint16_t> parse_port(std::string_view text) {
  uint16_t port = 0;
  const char* const end = text.data() + text.size();
  const auto [stopped, error] = std::from_chars(text.data(), end, port);
  if (error != std::errc() || stopped != end || port == 0) return std::nullopt;
  return port;
}

// Whether `text` is an IPv6 address, possibly with its interface: "fe80::1%eth0".
bool is_ipv6(std::string_view text) {
  const size_t zone = text.find('%');
  in6_addr address;
  return inet_pton(AF_INET6, std::string(text.substr(0, zone)).c_str(), &address) == 1 &&
         (zone == std::string_view::npos || zone + 1 < text.size());
}

bool is_host_name(std::string_view text) {
  constexpr size_t kMaxBytes = 253;  // RFC 1035, 2.3.4, not counting length bytes
  return !text.empty() && text.size() <= kMaxBytes &&
         std::ranges::all_of(text, [](unsigned char c) {
           return std::isalnum(c) || c == '-' || c == '.' || c == '_';
         });
}

class PacketWriter {
 public:
  PacketWriter(PacketType type, size_t expected_bytes) {
    bytes_.reserve(expected_bytes);
    put(uint32_t{0});  // the length, filled in by finish()
    put(type);
  }

  template <typename T>
  void put(const T& value) {
    append(&value, sizeof value);
  }
  void put_string(std::string_view text) {
    append(text.data(), text.size());
    put('\0');
  }
  void put_floats(const float* values, size_t count) { append(values, count * sizeof *values); }

  std::vector<std::byte> finish() && {
    const auto length = uint32_t(bytes_.size());
    std::memcpy(bytes_.data(), &length, sizeof length);
    return std::move(bytes_);
  }

 private:
  void append(const void* data, size_t size) {
    const auto* begin = static_cast<const std::byte*>(data);
    bytes_.insert(bytes_.end(), begin, begin + size);
  }

  std::vector<std::byte> bytes_;
};

}  // namespace

std::string TevAddress::url() const {
  const bool brackets = host.find(':') != std::string::npos;
  return fmt::format(fmt::runtime(brackets ? "{}[{}]:{}" : "{}{}:{}"), kScheme, host, port);
}

bool is_tev_url(std::string_view text) { return begins_with(text, "tev:"); }

TevAddress parse_tev_url(std::string_view url) {
  const auto invalid_url = [url](std::string_view why) -> UsageError {
    return UsageError(
        "`display`: '{}' {}; use tev://HOST:PORT, where HOST is a name, an IPv4 address or an "
        "[IPv6 address] and PORT is 1 to {} (default {})",
        shortened(url), why, std::numeric_limits<uint16_t>::max(), TevAddress::kDefaultPort);
  };
  if (!begins_with(url, kScheme)) throw invalid_url("is not a viewer address");
  const std::string_view place = url.substr(kScheme.size());
  const bool brackets = place.starts_with('[');
  const size_t host_end = brackets ? place.find(']') : std::min(place.find(':'), place.size());
  if (host_end == std::string_view::npos) throw invalid_url("has no closing bracket");
  const std::string_view host = place.substr(brackets, host_end - brackets);
  const std::string_view rest = place.substr(host_end + brackets);
  if (host.empty()) throw invalid_url("has no host");
  if (brackets ? !is_ipv6(host) : !is_host_name(host)) throw invalid_url("has an invalid host");
  TevAddress address{.host = std::string(host)};
  if (rest.empty()) return address;
  const std::optional<uint16_t> port =
      rest.starts_with(':') ? parse_port(rest.substr(1)) : std::nullopt;
  if (!port) throw invalid_url("has an invalid port");
  address.port = *port;
  return address;
}

std::vector<std::byte> tev_create_image(std::string_view name, int width, int height) {
  constexpr size_t kNumbers = 64;  // bytes; enough for everything except the name
  PacketWriter packet(PacketType::kCreateImage, name.size() + kNumbers);
  packet.put(true);
  packet.put_string(name);
  packet.put(int32_t(width));
  packet.put(int32_t(height));
  packet.put(int32_t(kChannels.size()));
  for (const std::string_view channel : kChannels) packet.put_string(channel);
  return std::move(packet).finish();
}

std::vector<std::byte> tev_update_image(std::string_view name, const Rect& rect,
                                        std::span<const float> rgba, const Rect& layout) {
  constexpr size_t kNumbers = 128;
  constexpr size_t kCount = kChannels.size();
  const size_t pixels = size_t(rect.area());
  PacketWriter packet(PacketType::kUpdateImageV3,
                      name.size() + kNumbers + pixels * kCount * sizeof(float));
  packet.put(false);
  packet.put_string(name);
  packet.put(int32_t(kCount));
  for (const std::string_view channel : kChannels) packet.put_string(channel);
  for (const int number : {rect.x0, rect.y0, rect.width(), rect.height()}) {
    packet.put(int32_t(number));
  }
  for (size_t c = 0; c < kCount; ++c) packet.put(int64_t(c));
  for (size_t c = 0; c < kCount; ++c) packet.put(int64_t(kCount));
  for (int y = rect.y0; y < rect.y1; ++y) {
    packet.put_floats(&rgba[kCount * layout.index_of(rect.x0, y)], kCount * size_t(rect.width()));
  }
  return std::move(packet).finish();
}

}  // namespace emberline
