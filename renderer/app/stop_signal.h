// Ctrl-C, SIGTERM and a closed terminal as a request to stop: while a frame renders, the first one
// lets it write what there is; a second one, or one at any other time, ends the process at once,
// with exit code 130 and without leaving unfinished files.
#pragma once

namespace emberline {

// Also makes a write past the file size limit (ulimit -f) an error like any other instead of a
// signal that kills the process.
void install_stop_handlers();

bool stop_signalled();

// While one lives, a first signal is a request. One at a time. A log that nobody reads any more
// (a closed pipe) does not end the process either.
class GracefulStop {
 public:
  GracefulStop();
  ~GracefulStop();
  GracefulStop(const GracefulStop&) = delete;
  GracefulStop& operator=(const GracefulStop&) = delete;
};

}  // namespace emberline
