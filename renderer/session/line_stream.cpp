#include "renderer/session/line_stream.h"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <climits>
#include <system_error>

#include "renderer/core/errors.h"

namespace emberline {
namespace {

// Unread output beyond this size counts as congestion. All events that are sent at one time fit,
// and so do most answers.
constexpr size_t kMaxUnreadBytes = size_t(64) << 10;
constexpr size_t kReadBytes = size_t(64) << 10;
// A pipe that is ready for writing accepts this many bytes without blocking the writer (POSIX,
// pipe(7)).
constexpr size_t kWriteBytes = PIPE_BUF;
constexpr auto kFlushTime = std::chrono::seconds(2);

[[noreturn]] void throw_unwritable(int error) {
  throw RenderError("cannot write to the standard output: " +
                    std::generic_category().message(error));
}

}  // namespace

LineStream::LineStream(int in, int out) : in_(in), out_(out) {
  if (::pipe(wake_) != 0) {
    throw RenderError("cannot create a pipe: " + std::generic_category().message(errno));
  }
  for (const int end : wake_) {
    ::fcntl(end, F_SETFL, O_NONBLOCK);
    ::fcntl(end, F_SETFD, FD_CLOEXEC);
  }
}

LineStream::~LineStream() {
  for (const int end : wake_) ::close(end);
}

std::optional<std::string> LineStream::next_line() {
  const size_t end = in_text_.find('\n', searched_);
  searched_ = end == std::string::npos ? in_text_.size() : 0;
  const size_t length = std::min(end, in_text_.size());
  if (length > kMaxLineBytes) {
    throw InputError("standard input", "a line has more than {} MiB", kMaxLineBytes >> 20);
  }
  if (end == std::string::npos) return std::nullopt;
  std::string line = in_text_.substr(0, end);
  in_text_.erase(0, end + 1);
  return line;
}

void LineStream::write(const std::string& line) {
  out_text_ += line;
  out_text_ += '\n';
}

bool LineStream::congested() const { return out_text_.size() > kMaxUnreadBytes; }

void LineStream::wait(std::optional<int> milliseconds) {
  pollfd ends[] = {{ended_ ? -1 : in_, short(congested() ? POLLRDHUP : POLLIN), 0},
                   {out_, short(out_text_.empty() ? 0 : POLLOUT), 0},
                   {wake_[0], POLLIN, 0}};
  if (::poll(ends, 3, milliseconds.value_or(-1)) < 0) return;  // interrupted by a signal
  if (ends[1].revents & (POLLERR | POLLHUP | POLLNVAL)) throw_unwritable(EPIPE);
  if (ends[1].revents & POLLOUT) write_some();
  if (ends[2].revents) {
    char bytes[64];
    while (::read(wake_[0], bytes, sizeof bytes) > 0) {
    }
  }
  // If the writer of the input is gone, reads even while the output is congested, because only a
  // finite amount is left in the pipe.
  if (ends[0].revents) read_some();
}

void LineStream::wake() {
  const char byte = 0;
  (void)!::write(wake_[1], &byte, 1);  // may fail: a full pipe wakes the reader anyway
}

void LineStream::flush() {
  auto end = std::chrono::steady_clock::now() + kFlushTime;
  while (!out_text_.empty() && std::chrono::steady_clock::now() < end) {
    pollfd out = {out_, POLLOUT, 0};
    if (::poll(&out, 1, 50) <= 0) continue;
    write_some();
    end = std::chrono::steady_clock::now() + kFlushTime;
  }
}

void LineStream::read_some() {
  const size_t before = in_text_.size();
  in_text_.resize(before + kReadBytes);
  const ssize_t count = ::read(in_, in_text_.data() + before, kReadBytes);
  in_text_.resize(before + size_t(std::max<ssize_t>(count, 0)));
  if (count == 0 || (count < 0 && errno != EINTR && errno != EAGAIN)) ended_ = true;
}

void LineStream::write_some() {
  const ssize_t count = ::write(out_, out_text_.data(), std::min(out_text_.size(), kWriteBytes));
  if (count > 0) {
    out_text_.erase(0, size_t(count));
  } else if (errno != EINTR && errno != EAGAIN) {
    throw_unwritable(errno);
  }
}

}  // namespace emberline
