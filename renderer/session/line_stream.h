// Reads lines from one descriptor and writes lines to another: the standard streams of `emberline
// session`. One thread waits for both, and other threads can wake it.
//
// Memory is bounded: a line has a maximum length, and nothing is read while the reader of the
// output lags behind.
#pragma once

#include <optional>
#include <string>

namespace emberline {

class LineStream {
 public:
  // This is enough for an edit of thousands of materials, the longest realistic command.
  static constexpr size_t kMaxLineBytes = size_t(4) << 20;

  LineStream(int in, int out);
  ~LineStream();
  LineStream(const LineStream&) = delete;
  LineStream& operator=(const LineStream&) = delete;

  // Returns the next complete line, without its line end, or nullopt if no line has arrived. Throws
  // InputError if a line is too long.
  std::optional<std::string> next_line();
  // Returns whether the input has ended.
  bool ended() const { return ended_; }
  // Returns whether there is input after the last line end.
  bool has_partial_line() const { return !in_text_.empty(); }

  // Queues a line; wait() and flush() write it.
  void write(const std::string& line);
  // Returns whether the reader of the output lags behind. If so, accept no commands and write no
  // optional lines.
  bool congested() const;

  // Waits for input, space for output, wake() or the timeout. Without a timeout, it may wait
  // forever. Throws RenderError if the reader of the output is gone.
  void wait(std::optional<int> milliseconds);
  // Ends wait(). May be called on any thread.
  void wake();
  // Waits until everything is written or the reader has accepted nothing for two seconds.
  void flush();

 private:
  void read_some();
  void write_some();

  const int in_, out_;
  int wake_[2] = {-1, -1};  // a pipe that ends wait()
  std::string in_text_, out_text_;
  size_t searched_ = 0;  // in_text_ has no line end before this index
  bool ended_ = false;
};

}  // namespace emberline
