#include "renderer/process/progress.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "renderer/core/log.h"
#include "renderer/core/readable.h"
#include "renderer/process/stop_signal.h"

namespace emberline {

using Seconds = std::chrono::duration<double>;

namespace {

// A terminal on which a line can be drawn over; an editor's shell buffer (TERM=dumb) is none.
bool is_capable_terminal() {
  const char* type = std::getenv("TERM");
  return isatty(STDERR_FILENO) && !(type && std::string_view(type) == "dumb");
}

// Columns of the terminal now: it may be resized while a frame renders.
int terminal_columns() {
  winsize size = {};
  if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return 80;
  return size.ws_col;
}

// "[====    ] text", in no more than `columns`: a line that wraps could not be drawn over. The bar
// gives way first, then the end of the text.
std::string bar_line(double fraction, std::string text, int columns) {
  constexpr int kFullWidth = 30, kLeastWidth = 5;
  const int width = std::min(kFullWidth, columns - 1 - int(text.size()) - 3);
  if (width < kLeastWidth) return text.substr(0, size_t(std::max(0, columns - 1)));
  std::string bar(size_t(fraction * width), '=');
  bar.resize(size_t(width), ' ');
  return "[" + bar + "] " + text;
}

}  // namespace

ProgressDisplay::ProgressDisplay(uint64_t samples_total, StopRequest& stop,
                                 std::optional<double> time_limit_s)
    : total_(samples_total),
      stop_(stop),
      time_limit_s_(time_limit_s),
      start_(std::chrono::steady_clock::now()),
      shown_(log_level() != LogLevel::kQuiet),
      terminal_(is_capable_terminal()) {
  if (shown_ && terminal_) {
    set_log_interrupt([] { std::fputs("\r\033[K", stderr); }, nullptr);
  }
  thread_ = std::thread([this] { run(); });
}

ProgressDisplay::~ProgressDisplay() {
  {
    const std::lock_guard lock(mutex_);
    finished_ = true;
  }
  wake_.notify_all();
  thread_.join();
  set_log_interrupt(nullptr, nullptr);
  if (shown_ && terminal_) {
    std::fputs("\r\033[K", stderr);
    std::fflush(stderr);
  }
}

void ProgressDisplay::stop_if_asked() {
  if (stop_signalled() && stop_.request(PixelStop::kUser)) {
    log_info("stopping and writing what there is; once more ends at once");
  }
  const double elapsed = Seconds(std::chrono::steady_clock::now() - start_).count();
  if (time_limit_s_ && elapsed >= *time_limit_s_ && stop_.request(PixelStop::kTimeLimit)) {
    log_info("the time limit is reached; writing what there is");
  }
}

void ProgressDisplay::run() {
  // 20 ms: soon enough for a stop to feel immediate, seldom enough to cost nothing.
  constexpr auto kPoll = std::chrono::milliseconds(20);
  constexpr double kLongestWait = 1e9;  // seconds; more would overflow the clock
  const auto limit =
      start_ + std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                   Seconds(std::min(time_limit_s_.value_or(kLongestWait), kLongestWait)));
  const auto next_look = [&] {
    const auto poll = std::chrono::steady_clock::now() + kPoll;
    return stop_.cause() == PixelStop::kNone ? std::min(poll, limit) : poll;
  };
  int polls = 0;
  std::unique_lock lock(mutex_);
  while (!wake_.wait_until(lock, next_look(), [this] { return finished_; })) {
    stop_if_asked();
    if (shown_ && ++polls % 5 == 0) draw();
  }
}

double ProgressDisplay::fraction(uint64_t done) const {
  if (total_ > 0) return double(done) / double(total_);
  return std::min(1.0, share_.load(std::memory_order_relaxed));
}

std::string ProgressDisplay::line(uint64_t done, double elapsed) const {
  const uint64_t earlier = earlier_.load(std::memory_order_relaxed);
  const double rate = elapsed > 0 ? double(done - std::min(done, earlier)) / elapsed : 0.0;
  const double fraction = this->fraction(done);
  const double before = total_ > 0 ? double(earlier) / double(total_)
                                   : earlier_share_.load(std::memory_order_relaxed);
  if (total_ == 0 && fraction == 0) {  // a threshold decides when it ends
    return fmt::format("{:.1f} M samples  {}  ({:.2f} M samples/s)", double(done) * 1e-6,
                       readable_seconds(elapsed), rate * 1e-6);
  }
  std::string text = fmt::format("{:5.1f} %  {}", 100 * fraction, readable_seconds(elapsed));
  if (fraction > before && fraction < 1) {
    text += ", " + readable_seconds(elapsed * (1 - fraction) / (fraction - before)) + " left";
  }
  return text + fmt::format("  ({:.2f} M samples/s)", rate * 1e-6);
}

void ProgressDisplay::draw() {
  uint64_t done = done_.load(std::memory_order_relaxed);
  if (total_ > 0) done = std::min(done, total_);
  const double elapsed = Seconds(std::chrono::steady_clock::now() - start_).count();
  if (terminal_) {
    std::fprintf(stderr, "\r%s\033[K",
                 bar_line(fraction(done), line(done, elapsed), terminal_columns()).c_str());
    std::fflush(stderr);
    return;
  }
  // Piped into a farm's log: a line for every tenth (or ten seconds, where the end is
  // not known), and a sign of life every minute.
  const double known = fraction(done);
  const int tenth = known > 0 || total_ > 0 ? int(10 * known) : int(elapsed / 10.0);
  if (tenth > last_tenth_ || elapsed > last_line_ + 60.0) {
    last_tenth_ = tenth;
    last_line_ = elapsed;
    log_info("rendering " + line(done, elapsed));
  }
}

}  // namespace emberline
