// Reads lines from one descriptor and writes lines to another, for one thread that waits for both
// and for other threads: the standard streams of `emberline session`.
//
// Its memory is bounded: a line has a maximum length, and input waits while the reader lags.
#pragma once

#include <optional>
#include <string>

namespace emberline {

class LineStream {
 public:
  // Enough for an edit of thousands of materials, the longest realistic command.
  static constexpr size_t kMaxLineBytes = size_t(4) << 20;

  LineStream(int in, int out);
  ~LineStream();
  LineStream(const LineStream&) = delete;
  LineStream& operator=(const LineStream&) = delete;

  // Returns the next complete line, without its line end.
  std::optional<std::string> next_line();
  // The input has ended.
  bool ended() const { return ended_; }
  // Whether there is text after the last line end.
  bool has_partial_line() const { return !in_text_.empty(); }

  // Queues a line; wait() and flush() write it.
  void write(const std::string& line);
  // The reader lags: do not take commands or write optional lines.
  bool congested() const;

  // Waits for input, output space, wake(), or the timeout (none: forever). Throws InputError for a
  // line that is too long, RenderError if the reader is gone.
  void wait(std::optional<int> milliseconds);
  // Ends wait(). Any thread.
  void wake();
  // Waits until everything is written, or the reader accepts nothing for two seconds.
  void flush();

 private:
  void read_some();
  void write_some();

  const int in_, out_;
  int wake_[2] = {-1, -1};  // a pipe
  std::string in_text_, out_text_;
  size_t searched_ = 0;  // prefix of in_text_ without a line end
  bool ended_ = false;
};

}  // namespace emberline
