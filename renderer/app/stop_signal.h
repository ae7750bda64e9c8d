// Signals that ask the process to stop: Ctrl-C, Ctrl-\, SIGTERM, a closed terminal, or the CPU time
// limit. While a frame renders, the first signal lets the unfinished frame be written. A second
// signal, or any signal at another time, removes unfinished files and ends the process at once with
// exit code 130.
#pragma once

namespace emberline {

// Installs the signal handlers. Also makes writes that exceed the file size limit (ulimit -f) or go
// to a closed pipe fail with an ordinary error, instead of a signal that kills the process.
void install_stop_handlers();

bool stop_signalled();

// SIGUSR1 requests that the checkpoint is saved. It has no effect if the frame has no checkpoint.
bool take_checkpoint_request();  // true: requested since the last call

// While an instance exists, the first signal only requests a stop. At most one instance may exist
// at a time.
class GracefulStop {
 public:
  GracefulStop();
  ~GracefulStop();
  GracefulStop(const GracefulStop&) = delete;
  GracefulStop& operator=(const GracefulStop&) = delete;
};

}  // namespace emberline
