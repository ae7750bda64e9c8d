// A TCP connection for sending, in which every wait can be cancelled.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "io/files/descriptor.h"

namespace emberline {

// Not thread-safe. A connection that the peer closes causes an error and not a signal.
class TcpClient {
 public:
  // The client calls this at the start of a wait and then every 20 ms, with the seconds waited so
  // far. A result of false cancels the wait.
  using KeepWaiting = std::function<bool(double)>;

  // Connects to the first of the host's addresses that answers. All attempts together take at most
  // `timeout_s`. Throws RenderError with a short reason: "cannot connect: Connection refused".
  TcpClient(const std::string& host, uint16_t port, double timeout_s, KeepWaiting keep_waiting);

  // Returns once the system has accepted all bytes. The system continues to send them after this
  // object is destroyed. Throws RenderError if the peer has closed the connection or the wait was
  // cancelled; a part of the data may have been sent by then.
  void send(std::span<const std::byte> bytes);

 private:
  bool connect_to(const void* address, double deadline);
  short wait_for(short events, double deadline) const;

  KeepWaiting keep_waiting_;
  Descriptor socket_;
  int last_error_ = 0;  // errno of the last address tried
};

}  // namespace emberline
