// Lines of text in from one descriptor and out to another, for one thread that waits for both and
// for news of other threads: the standard streams of `emberline session`.
//
// Neither end can make it grow: a line has a limit, and a reader that lags is not listened to.
#pragma once

#include <optional>
#include <string>

namespace emberline {

class LineStream {
 public:
  // Far more than any command needs; what an edit of thousands of materials takes.
  static constexpr size_t kLongestLine = size_t(4) << 20;

  LineStream(int in, int out);
  ~LineStream();
  LineStream(const LineStream&) = delete;
  LineStream& operator=(const LineStream&) = delete;

  // The next line that has come, without its end.
  std::optional<std::string> take();
  // No more will come.
  bool ended() const { return ended_; }
  // Whether text has come after the last line's end.
  bool mid_line() const { return !in_text_.empty(); }

  // For the reader, in its own time.
  void write(const std::string& line);
  // The reader lags: nothing is to be taken or written that can wait.
  bool congested() const;

  // Waits for input, room for output, wake(), or the end of this time; without one, for as long as
  // it takes. Throws InputError for a line that is too long, RenderError if the reader is gone.
  void wait(std::optional<int> milliseconds);
  // Any thread: there is news.
  void wake();
  // Waits until all is written, or the reader takes nothing for two seconds.
  void flush();

 private:
  void read_some();
  void write_some();

  const int in_, out_;
  int wake_[2] = {-1, -1};  // a pipe
  std::string in_text_, out_text_;
  size_t searched_ = 0;  // of in_text_: no line ends there
  bool ended_ = false;
};

}  // namespace emberline
