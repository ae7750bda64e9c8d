// A TCP connection that is only written to, and whose every wait can be called off.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "io/files/descriptor.h"

namespace emberline {

// One thread at a time. A peer that is gone is an error, never a signal.
class TcpClient {
 public:
  // Asked at the beginning of a wait, and every 20 ms from then on, with the seconds that it has
  // lasted; false ends it.
  using KeepWaiting = std::function<bool(double)>;

  // Connects to the first of the host's addresses that answers, all of them within `timeout_s`.
  // Throws RenderError that says in a few words what went wrong: "cannot connect:
  // Connection refused".
  TcpClient(const std::string& host, uint16_t port, double timeout_s, KeepWaiting keep_waiting);

  // Returns when the system has taken all of it; it goes on sending after the object's end. Throws
  // RenderError when the peer has closed, or the wait was called off: then some of it was sent.
  void send(std::span<const std::byte> bytes);

 private:
  bool connect_to(const void* address, double until);
  short wait_for(short events, double until) const;

  KeepWaiting keep_waiting_;
  Descriptor socket_;
  int last_error_ = 0;  // errno of the last address that was tried
};

}  // namespace emberline
