#include "io/viewer/tcp_client.h"

#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>

#include <cerrno>
#include <chrono>
#include <future>
#include <limits>
#include <memory>
#include <system_error>
#include <thread>
#include <utility>

#include "renderer/core/errors.h"

namespace emberline {
namespace {

constexpr int kPollMs = 20;

using AddressList = std::unique_ptr<addrinfo, void (*)(addrinfo*)>;

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::string error_text(int error) { return std::generic_category().message(error); }

struct LookupResult {
  AddressList list;
  std::string fault;  // the error, if `list` is null
};

LookupResult resolve_host(const std::string& host, uint16_t port, int flags) {
  addrinfo hints = {};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = flags | AI_NUMERICSERV;
  addrinfo* list = nullptr;
  const int error = getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &list);
  const std::string fault = error == 0            ? ""
                            : error == EAI_SYSTEM ? error_text(errno)
                                                  : gai_strerror(error);
  return {AddressList(list, freeaddrinfo), fault};
}

// A name lookup cannot be cancelled and may take half a minute. Therefore it runs on a detached
// thread that owns all its data, and it is abandoned on timeout.
LookupResult resolve_host_name(const std::string& host, uint16_t port, double deadline,
                               const TcpClient::KeepWaiting& keep_waiting) {
  std::packaged_task<LookupResult()> task([host, port] { return resolve_host(host, port, 0); });
  std::future<LookupResult> answer = task.get_future();
  std::thread(std::move(task)).detach();
  const double began = now();
  while (answer.wait_for(std::chrono::milliseconds(kPollMs)) != std::future_status::ready) {
    if (now() > deadline || !keep_waiting(now() - began)) {
      return {AddressList(nullptr, freeaddrinfo), "no answer in time"};
    }
  }
  return answer.get();
}

// Throws RenderError.
AddressList addresses(const std::string& host, uint16_t port, double deadline,
                      const TcpClient::KeepWaiting& keep_waiting) {
  LookupResult answer = resolve_host(host, port, AI_NUMERICHOST);  // no lookup over the network
  if (!answer.list) answer = resolve_host_name(host, port, deadline, keep_waiting);
  if (!answer.list) throw RenderError("cannot find the host: " + answer.fault);
  return std::move(answer.list);
}

}  // namespace

TcpClient::TcpClient(const std::string& host, uint16_t port, double timeout_s,
                     KeepWaiting keep_waiting)
    : keep_waiting_(std::move(keep_waiting)) {
  const double deadline = now() + timeout_s;
  const AddressList list = addresses(host, port, deadline, keep_waiting_);
  for (const addrinfo* address = list.get(); address; address = address->ai_next) {
    if (connect_to(address, deadline)) return;
  }
  throw RenderError("cannot connect: " + error_text(last_error_));
}

bool TcpClient::connect_to(const void* address, double deadline) {
  const auto& a = *static_cast<const addrinfo*>(address);
  socket_ =
      Descriptor(socket(a.ai_family, a.ai_socktype | SOCK_NONBLOCK | SOCK_CLOEXEC, a.ai_protocol));
  last_error_ = socket_ < 0 ? errno : 0;
  if (socket_ >= 0 && connect(socket_, a.ai_addr, a.ai_addrlen) != 0) last_error_ = errno;
  if (last_error_ == EINPROGRESS) {
    socklen_t size = sizeof last_error_;
    if (wait_for(POLLOUT, deadline) == 0) {
      last_error_ = ETIMEDOUT;
    } else {
      getsockopt(socket_, SOL_SOCKET, SO_ERROR, &last_error_, &size);
    }
  }
  return last_error_ == 0;
}

// Waits for `events` or an error. Returns the poll events that arrived, or 0 if the wait timed out
// or was cancelled.
short TcpClient::wait_for(short events, double deadline) const {
  const double began = now();
  pollfd ready = {socket_, events, 0};
  for (double time = began; time <= deadline && keep_waiting_(time - began); time = now()) {
    if (poll(&ready, 1, kPollMs) > 0) return ready.revents;
  }
  return 0;
}

void TcpClient::send(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const short ready = wait_for(POLLOUT | POLLRDHUP, std::numeric_limits<double>::infinity());
    if (ready == 0) throw RenderError("the viewer stopped reading the picture");
    if (ready & POLLRDHUP) throw RenderError("the viewer closed the connection");
    const ssize_t sent = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent > 0) bytes = bytes.subspan(size_t(sent));
    if (sent < 0 && errno != EAGAIN && errno != EINTR) throw RenderError(error_text(errno));
  }
}

}  // namespace emberline
