// Signals that ask for the end: Ctrl-C, Ctrl-\, SIGTERM, a closed terminal, processor time that is
// spent. While a frame renders, the first one lets it write what there is; a second one, or one at
// any other time, ends the process at once, with exit code 130 and without leaving unfinished
// files.
#pragma once

namespace emberline {

// Also makes a write past the file size limit (ulimit -f) and one into a pipe that nobody reads any
// more errors like any other, instead of signals that kill the process.
void install_stop_handlers();

bool stop_signalled();

// SIGUSR1 asks for a checkpoint; without one under way it does nothing.
bool take_checkpoint_request();  // true: one has come since the last call

// While one lives, a first signal is a request. One at a time.
class GracefulStop {
 public:
  GracefulStop();
  ~GracefulStop();
  GracefulStop(const GracefulStop&) = delete;
  GracefulStop& operator=(const GracefulStop&) = delete;
};

}  // namespace emberline
