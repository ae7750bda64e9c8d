// Runs the emberline binary as a user or a farm script does, and records the result.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "support/sanitized.h"

namespace emberline::test {

struct RunOptions {
  std::string folder = {};                              // working folder; empty: the test's
  std::map<std::string, std::string> environment = {};  // adds to or overrides the test's
  std::string stdout_path = {};                // file for stdout, which is then not captured
  double timeout_s = 60 * kSanitizerSlowdown;  // after this it is killed and counts as hung
  uint64_t file_size_limit = 0;                // RLIMIT_FSIZE in bytes; 0: none
  uint64_t data_limit = 0;                     // RLIMIT_DATA in bytes; 0: none
  uint64_t process_limit = 0;                  // RLIMIT_NPROC, as another user; needs root; 0: none
  int processors = 0;               // > 0: restricts it to this many of the test's processors
  int terminal_columns = 0;         // > 0: stderr is a terminal of this width
  std::vector<int> closed = {};     // standard streams that are closed
  int ignored_signal = 0;           // a signal that is ignored from the start, as under nohup
  bool stderr_reader_gone = false;  // stderr is a pipe without a reader
  bool unprivileged = false;        // runs as user 65534 if the tests run as root
};

struct RunResult {
  int exit_code = -1;  // -1 if a signal has ended it
  int signal = 0;
  bool hung = false;
  std::string out, err;
  double seconds = 0;
  double stop_cpu_s = 0;  // processor time since the last signal, or the start
  uint64_t peak_rss_bytes = 0;

  std::vector<std::string> error_lines() const;  // the lines of stderr
  std::string describe() const;                  // for failure messages
};

// A running emberline; the destructor kills it.
class Process {
 public:
  explicit Process(const std::vector<std::string>& arguments, const RunOptions& options = {});
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  void send(int signal);
  // The contents of stderr so far.
  std::string error_so_far();
  // Waits until stderr contains `text`. Returns false if the process ends or `seconds` pass first.
  bool wait_for_error(const std::string& text, double seconds);
  // Waits until stderr contains `text` and the process has since used `cpu_s` of processor time, a
  // measure of progress that other load does not affect. Returns false if the process ends first.
  bool wait_until_busy(const std::string& text = "loaded in",
                       double cpu_s = 0.5 * kSanitizerSlowdown);
  RunResult wait();

 private:
  bool poll(int flags);
  double cpu_seconds() const;  // processor time of all its threads so far
  void read_terminal();
  [[noreturn]] void run_child(const std::vector<std::string>& arguments, int binary);

  RunOptions options_;
  pid_t pid_ = -1;
  int out_ = -1, err_ = -1;  // files in memory; `err_` may be our end of the terminal
  bool ended_ = false;
  double started_ = 0, signalled_cpu_s_ = 0;
  std::string terminal_text_;
  RunResult result_;
};

RunResult run(const std::vector<std::string>& arguments, const RunOptions& options = {});

}  // namespace emberline::test
