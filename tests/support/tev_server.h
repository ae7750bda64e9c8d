// A viewer for tests. It listens as tev does, and decodes the packets into images. The decoder was
// written from tev's published packet layout and not from our encoder.
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <cstring>
#include <limits>
#include <map>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "renderer/core/rect.h"

namespace emberline::test {

struct TevImage {
  int width = 0, height = 0;
  std::vector<std::string> channels;
  std::map<std::string, std::vector<float>> values;  // by channel, in rows from the top
  std::vector<Rect> updates;                         // in the order in which they arrived

  float at(const std::string& channel, int x, int y) const {
    return values.at(channel)[size_t(y) * size_t(width) + size_t(x)];
  }
};

// Reads numbers and strings from a packet, in order. Throws std::runtime_error if it would read
// beyond the end of the packet.
class TevPacketReader {
 public:
  explicit TevPacketReader(const std::vector<unsigned char>& bytes) : bytes_(bytes) {}

  int64_t integer(int size) {
    uint64_t value = 0;
    for (int i = 0; i < size; ++i) value |= uint64_t(byte()) << (8 * i);
    return size == 4 ? int64_t(int32_t(uint32_t(value))) : int64_t(value);
  }
  std::string string() {
    std::string text;
    for (unsigned char c; (c = byte()) != 0;) text += char(c);
    return text;
  }
  float float_at(size_t index) const {  // counts floats from the current position
    if (at_ + 4 * index + 4 > bytes_.size()) throw std::runtime_error("too few values");
    float value;
    std::memcpy(&value, &bytes_[at_ + 4 * index], 4);
    return value;
  }
  size_t remaining_bytes() const { return bytes_.size() - at_; }
  unsigned char byte() {
    if (at_ >= bytes_.size()) throw std::runtime_error("a packet ends too soon");
    return bytes_[at_++];
  }

 private:
  const std::vector<unsigned char>& bytes_;
  size_t at_ = 0;
};

using TevImages = std::map<std::string, TevImage>;

inline void decode_create(TevPacketReader& packet, TevImages& images) {
  packet.byte();  // skips a flag: whether tev shows the image
  TevImage& image = images[packet.string()] = {};
  image.width = int(packet.integer(4));
  image.height = int(packet.integer(4));
  for (int64_t n = packet.integer(4); n > 0; --n) {
    image.channels.push_back(packet.string());
    image.values[image.channels.back()].resize(size_t(image.width) * size_t(image.height));
  }
  if (packet.remaining_bytes() != 0) throw std::runtime_error("CreateImage is too long");
}

inline void decode_update(TevPacketReader& packet, TevImages& images) {
  packet.byte();  // skips a flag: whether tev shows the image
  TevImage& image = images.at(packet.string());
  std::vector<std::string> channels(size_t(packet.integer(4)));
  for (std::string& channel : channels) channel = packet.string();
  const int x = int(packet.integer(4)), y = int(packet.integer(4));
  const int width = int(packet.integer(4)), height = int(packet.integer(4));
  const Rect rect{x, y, x + width, y + height};
  if (rect.empty() || rect.intersect({0, 0, image.width, image.height}) != rect) {
    throw std::runtime_error("an update extends beyond its image");
  }
  image.updates.push_back(rect);
  std::vector<int64_t> offsets(channels.size()), strides(channels.size());
  for (int64_t& offset : offsets) offset = packet.integer(8);
  for (int64_t& stride : strides) stride = packet.integer(8);
  for (size_t c = 0; c < channels.size(); ++c) {
    std::vector<float>& values = image.values.at(channels[c]);
    for (int64_t i = 0; i < rect.area(); ++i) {
      const size_t pixel_index =
          size_t(rect.y_of(size_t(i))) * size_t(image.width) + size_t(rect.x_of(size_t(i)));
      values[pixel_index] = packet.float_at(size_t(offsets[c] + i * strides[c]));
    }
  }
  if (packet.remaining_bytes() != channels.size() * size_t(rect.area()) * 4) {
    throw std::runtime_error("an update does not have one value per pixel");
  }
}

// Decodes one packet, which begins with its length. Throws std::exception for a packet that tev
// would not understand.
inline void decode_tev_packet(const std::vector<unsigned char>& bytes, TevImages& images) {
  TevPacketReader packet(bytes);
  if (uint64_t(packet.integer(4)) != bytes.size())
    throw std::runtime_error("the length of a packet is wrong");
  switch (packet.byte()) {
    case 4:
      return decode_create(packet, images);
    case 6:
      return decode_update(packet, images);
    default:
      throw std::runtime_error("unknown packet type");
  }
}

// Serves one connection on a separate thread, until the peer closes the connection.
class TevServer {
 public:
  struct Behaviour {
    bool ipv6 = false;
    bool reads = true;  // if false, the server accepts, but reads only after start_reading()
    size_t closes_after = std::numeric_limits<size_t>::max();  // received bytes
    useconds_t pause_us = 0;                                   // before each read from the socket
  };

  TevServer() : TevServer(Behaviour()) {}
  explicit TevServer(const Behaviour& behaviour) : behaviour_(behaviour), reads_(behaviour.reads) {
    listener_ = ::socket(behaviour.ipv6 ? AF_INET6 : AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (!behaviour.reads || behaviour.pause_us > 0) {
      // The receive buffer is small, so that the sender soon blocks if this server does not read.
      const int size = 4096;
      ::setsockopt(listener_, SOL_SOCKET, SO_RCVBUF, &size, sizeof size);
    }
    sockaddr_in6 v6 = {};
    v6.sin6_family = AF_INET6;
    v6.sin6_addr = in6addr_loopback;
    sockaddr_in v4 = {};
    v4.sin_family = AF_INET;
    v4.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    auto* address =
        behaviour.ipv6 ? reinterpret_cast<sockaddr*>(&v6) : reinterpret_cast<sockaddr*>(&v4);
    socklen_t size = behaviour.ipv6 ? sizeof v6 : sizeof v4;
    if (::bind(listener_, address, size) != 0 || ::listen(listener_, 1) != 0) return;
    ::getsockname(listener_, address, &size);
    port_ = ntohs(behaviour.ipv6 ? v6.sin6_port : v4.sin_port);
    thread_ = std::thread([this] { serve(); });
  }
  ~TevServer() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
    if (listener_ >= 0) ::close(listener_);
  }
  TevServer(const TevServer&) = delete;
  TevServer& operator=(const TevServer&) = delete;

  int port() const { return port_; }  // 0 if this system has no IPv4 or IPv6, as requested
  std::string url() const {
    return (behaviour_.ipv6 ? "tev://[::1]:" : "tev://127.0.0.1:") + std::to_string(port_);
  }

  void start_reading() { reads_ = true; }

  // Waits until the connection ends. Returns the first error in the packets, or "".
  std::string wait() {
    if (thread_.joinable()) thread_.join();
    return fault_;
  }
  // The images are complete after wait().
  const TevImages& images() const { return images_; }
  // Returns the first image, for tests that send only one.
  const TevImage& image() const { return images_.begin()->second; }
  bool connected() const { return connected_; }

 private:
  bool readable(int socket) const {
    pollfd ready = {socket, POLLIN, 0};
    while (!stop_) {
      if (::poll(&ready, 1, 10) > 0) return true;
    }
    return false;
  }

  void serve() {
    if (!readable(listener_)) return;
    const int socket = ::accept(listener_, nullptr, nullptr);
    connected_ = true;
    while (!reads_ && !stop_) ::usleep(1000);
    std::vector<unsigned char> bytes(1 << 16), pending;
    for (size_t total = 0; readable(socket);) {
      ::usleep(behaviour_.pause_us);
      const ssize_t n = ::recv(socket, bytes.data(), bytes.size(), 0);
      if (n <= 0) break;
      total += size_t(n);
      if (total >= behaviour_.closes_after) break;
      pending.insert(pending.end(), bytes.begin(), bytes.begin() + n);
      decode(pending);
    }
    if (!pending.empty() && fault_.empty()) fault_ = "the last packet is incomplete";
    ::close(socket);
  }

  // Decodes the complete packets at the beginning of `pending` and removes them.
  void decode(std::vector<unsigned char>& pending) {
    size_t at = 0;
    while (fault_.empty() && pending.size() - at >= 4) {
      uint32_t length;
      std::memcpy(&length, &pending[at], 4);
      if (pending.size() - at < length) break;
      try {
        decode_tev_packet(
            {pending.begin() + ptrdiff_t(at), pending.begin() + ptrdiff_t(at + length)}, images_);
      } catch (const std::exception& error) {
        fault_ = error.what();
      }
      at += length;
    }
    pending.erase(pending.begin(), pending.begin() + ptrdiff_t(at));
  }

  const Behaviour behaviour_;
  int listener_ = -1;
  int port_ = 0;
  std::atomic<bool> reads_, stop_{false}, connected_{false};
  TevImages images_;
  std::string fault_;
  std::thread thread_;
};

}  // namespace emberline::test
