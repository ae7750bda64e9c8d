// Runs the emberline binary as a user or a script on a farm does, and records the result.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "support/sanitized.h"

namespace emberline::test {

struct RunOptions {
  std::string folder = {};                              // working folder; empty: the test's folder
  std::map<std::string, std::string> environment = {};  // adds or overrides variables
  std::string stdout_path = {};                // stdout goes to this file and is not captured
  double timeout_s = 60 * kSanitizerSlowdown;  // the run is then killed and counts as hung
  uint64_t file_size_limit = 0;                // RLIMIT_FSIZE in bytes; 0: no limit
  uint64_t data_limit = 0;                     // RLIMIT_DATA in bytes; 0: no limit
  uint64_t process_limit = 0;       // RLIMIT_NPROC, as another user; needs root; 0: no limit
  int processors = 0;               // > 0: the run may use only this many processors
  int terminal_columns = 0;         // > 0: stderr is a terminal of this width
  std::vector<int> closed = {};     // standard streams that are closed
  int ignored_signal = 0;           // a signal that is ignored from the start, as with nohup
  bool stderr_reader_gone = false;  // stderr is a pipe without a reader
  bool unprivileged = false;        // runs as user 65534 if the tests run as root
};

struct RunResult {
  int exit_code = -1;  // -1 if a signal ended the run
  int signal = 0;
  bool hung = false;
  std::string out, err;
  double seconds = 0;
  double stop_cpu_s = 0;  // processor time since the last signal, or since the start
  uint64_t peak_rss_bytes = 0;

  std::vector<std::string> error_lines() const;  // the lines of stderr
  std::string describe() const;                  // describes the run in failure messages
};

// A running emberline. The destructor kills it.
class Process {
 public:
  explicit Process(const std::vector<std::string>& arguments, const RunOptions& options = {});
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  void send(int signal);
  // Returns the contents of stderr so far.
  std::string error_so_far();
  // Waits until stderr contains `text`. Returns false if the process ends or `seconds` pass first.
  bool wait_for_error(const std::string& text, double seconds);
  // Waits until stderr contains `text`, and until the process has then used `cpu_s` seconds of
  // processor time, which is a measure of progress that other load does not affect. Returns false
  // if the process ends first.
  bool wait_until_busy(const std::string& text = "loaded in",
                       double cpu_s = 0.5 * kSanitizerSlowdown);
  RunResult wait();

 private:
  bool poll(int flags);
  double cpu_seconds() const;  // processor time of all threads of the process so far
  void read_terminal();
  [[noreturn]] void run_child(const std::vector<std::string>& arguments, int binary);

  RunOptions options_;
  pid_t pid_ = -1;
  int out_ = -1, err_ = -1;  // files in memory; `err_` may instead be our end of the terminal
  bool ended_ = false;
  double started_ = 0, signalled_cpu_s_ = 0;
  std::string terminal_text_;
  RunResult result_;
};

RunResult run(const std::vector<std::string>& arguments, const RunOptions& options = {});

}  // namespace emberline::test
