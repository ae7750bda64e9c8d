#include "renderer/app/progress.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string_view>
#include <utility>

#include "renderer/app/stop_signal.h"
#include "renderer/core/log.h"
#include "renderer/core/readable.h"

namespace emberline {

using Seconds = std::chrono::duration<double>;

namespace {

// Whether stderr is a terminal that can overwrite a line. An editor's shell buffer (TERM=dumb)
// cannot.
bool is_capable_terminal() {
  const char* type = std::getenv("TERM");
  return isatty(STDERR_FILENO) && !(type && std::string_view(type) == "dumb");
}

// Queries the width each time, because the user may resize the terminal during a render.
int terminal_columns() {
  winsize size = {};
  if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return 80;
  return size.ws_col;
}

// Returns "[====    ] text". The line is shorter than `columns`, because a line that wraps could
// not be overwritten. On a narrow terminal, drops the bar first, then the end of the text.
std::string bar_line(double fraction, std::string text, int columns) {
  constexpr int kFullWidth = 30, kMinWidth = 5;
  const int width = std::min(kFullWidth, columns - 1 - int(text.size()) - 3);
  if (width < kMinWidth) return text.substr(0, size_t(std::max(0, columns - 1)));
  std::string bar(size_t(fraction * width), '=');
  bar.resize(size_t(width), ' ');
  return "[" + bar + "] " + text;
}

}  // namespace

ProgressDisplay::ProgressDisplay(uint64_t samples_total, StopRequest& stop,
                                 std::optional<TimeLimit> limit, std::optional<double> allotted_s,
                                 std::string label, ProgressFile* file)
    : total_(samples_total),
      stop_(stop),
      limit_(limit),
      allotted_s_(allotted_s),
      label_(label.empty() ? "" : std::move(label) + "  "),
      file_(file),
      start_(std::chrono::steady_clock::now()),
      is_visible_(log_level() != LogLevel::kQuiet),
      is_terminal_(is_capable_terminal()) {
  if (is_visible_ && is_terminal_) {
    set_log_hook([] { std::fputs("\r\033[K", stderr); });
  }
  thread_ = std::jthread([this](const std::stop_token& thread_stop) { run(thread_stop); });
  if (file_) file_->set_source([this] { return now(); });
}

ProgressDisplay::~ProgressDisplay() {
  if (file_) file_->set_source(nullptr);
  thread_.request_stop();
  thread_.join();
  set_log_hook(nullptr);
  if (is_visible_ && is_terminal_) {
    std::fputs("\r\033[K", stderr);
    std::fflush(stderr);
  }
}

void ProgressDisplay::check_stop() {
  if (stop_signalled() && stop_.request(PixelStop::kUser)) {
    log_info("stopping and writing the picture so far; interrupt again to end at once");
  }
  const double elapsed = Seconds(std::chrono::steady_clock::now() - start_).count();
  if (limit_ && elapsed >= limit_->seconds && stop_.request(limit_->cause) &&
      limit_->cause == PixelStop::kTimeLimit) {
    log_info("the time limit is reached; writing the picture so far");
  }
  if (allotted_s_ && elapsed >= *allotted_s_ && stop_.request(PixelStop::kUser)) {
    log_info("the job's time is nearly over; stopping and writing the picture so far");
  }
}

void ProgressDisplay::run(const std::stop_token& thread_stop) {
  // With 20 ms, a stop feels immediate, and polling costs almost nothing.
  constexpr auto kPollInterval = std::chrono::milliseconds(20);
  constexpr double kMaxWait = 1e9;  // seconds; more would overflow the clock
  const auto limit = start_ + std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                                  Seconds(std::min({limit_ ? limit_->seconds : kMaxWait,
                                                    allotted_s_.value_or(kMaxWait), kMaxWait})));
  const auto next_poll = [&] {
    const auto poll = std::chrono::steady_clock::now() + kPollInterval;
    return stop_.cause() == PixelStop::kNone ? std::min(poll, limit) : poll;
  };
  int polls = 0;
  std::unique_lock lock(mutex_);
  while (!wake_.wait_until(lock, thread_stop, next_poll(),
                           [&] { return thread_stop.stop_requested(); })) {
    check_stop();
    if (is_visible_ && ++polls % 5 == 0) draw();
  }
}

double ProgressDisplay::fraction(uint64_t done, double elapsed_s) const {
  if (total_ > 0) return double(done) / double(total_);
  constexpr double kNearlyDone = 0.99;  // a frame may take longer than expected
  const double expected_s = expected_s_.load(std::memory_order_relaxed);
  if (expected_s > 0) return std::min(kNearlyDone, elapsed_s / expected_s);
  return std::min(1.0, fraction_.load(std::memory_order_relaxed));
}

RenderProgress ProgressDisplay::now() const {
  RenderProgress now;
  now.samples = done_.load(std::memory_order_relaxed);
  if (total_ > 0) now.samples = std::min(now.samples, total_);
  now.elapsed_s = Seconds(std::chrono::steady_clock::now() - start_).count();
  now.done = fraction(now.samples, now.elapsed_s);
  const double resumed_fraction =
      total_ > 0 ? double(resumed_samples_.load(std::memory_order_relaxed)) / double(total_)
                 : resumed_fraction_.load(std::memory_order_relaxed);
  if (now.done > resumed_fraction && now.done < 1) {
    now.left_s = now.elapsed_s * (1 - now.done) / (now.done - resumed_fraction);
  }
  return now;
}

std::string ProgressDisplay::line(const RenderProgress& now) const {
  const uint64_t earlier = std::min(now.samples, resumed_samples_.load(std::memory_order_relaxed));
  const double rate = now.elapsed_s > 0 ? double(now.samples - earlier) / now.elapsed_s : 0.0;
  if (total_ == 0 && now.done == 0) {  // the total is unknown, because a noise threshold decides
    return fmt::format("{}{:.1f} M samples  {}  ({:.2f} M samples/s)", label_,
                       double(now.samples) * 1e-6, readable_seconds(now.elapsed_s), rate * 1e-6);
  }
  std::string text =
      fmt::format("{}{:5.1f} %  {}", label_, 100 * now.done, readable_seconds(now.elapsed_s));
  if (now.left_s) text += ", " + readable_seconds(*now.left_s) + " left";
  return text + fmt::format("  ({:.2f} M samples/s)", rate * 1e-6);
}

void ProgressDisplay::draw() {
  const RenderProgress now = this->now();
  if (is_terminal_) {
    std::fprintf(stderr, "\r%s\033[K", bar_line(now.done, line(now), terminal_columns()).c_str());
    std::fflush(stderr);
    return;
  }
  // The output is not a terminal. Logs a line for every tenth of the frame (every ten seconds if
  // the total is unknown), and at least one line per minute.
  const int tenth = now.done > 0 || total_ > 0 ? int(10 * now.done) : int(now.elapsed_s / 10.0);
  if (tenth > last_tenth_ || now.elapsed_s > last_line_s_ + 60.0) {
    last_tenth_ = tenth;
    last_line_s_ = now.elapsed_s;
    log_info("rendering " + line(now));
  }
}

}  // namespace emberline
