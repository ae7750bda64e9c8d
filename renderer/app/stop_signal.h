// Signals that ask the process to stop: Ctrl-C, Ctrl-\, SIGTERM, a closed terminal, spent processor
// time. While a frame renders, the first one lets the unfinished frame be written. A second one, or
// one at any other time, ends the process at once with exit code 130 and removes unfinished files.
#pragma once

namespace emberline {

// Also turns writes past the file size limit (ulimit -f) and into a closed pipe into ordinary
// errors, instead of signals that kill the process.
void install_stop_handlers();

bool stop_signalled();

// SIGUSR1 requests a checkpoint; it has no effect while none is kept.
bool take_checkpoint_request();  // true: a request came since the last call

// While an instance lives, the first signal is only a request. At most one instance may exist.
class GracefulStop {
 public:
  GracefulStop();
  ~GracefulStop();
  GracefulStop(const GracefulStop&) = delete;
  GracefulStop& operator=(const GracefulStop&) = delete;
};

}  // namespace emberline
