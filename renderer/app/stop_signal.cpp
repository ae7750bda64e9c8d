#include "renderer/app/stop_signal.h"

#include <unistd.h>

#include <atomic>
#include <csignal>

#include "io/files/atomic_file.h"
#include "renderer/core/errors.h"

namespace emberline {
namespace {

// Atomic, because the handler may run on any thread while other threads read these variables.
// Lock-free, because a signal handler must not lock.
std::atomic<int> g_signal_count{0};
std::atomic<int> g_is_graceful{0};
std::atomic<int> g_checkpoint_requested{0};
static_assert(std::atomic<int>::is_always_lock_free);

void on_signal(int signal) {
  const int count = ++g_signal_count;
  // SIGXCPU (ulimit -t) repeats every second, so a second SIGXCPU does not mean that the user wants
  // to end the process at once.
  if (g_is_graceful != 0 && (count == 1 || signal == SIGXCPU)) return;
  remove_unfinished_files();
  _exit(kExitStopped);
}

void on_checkpoint_signal(int) { g_checkpoint_requested = 1; }

void set_action(int signal, void (*handler)(int)) {
  struct sigaction action = {};
  action.sa_handler = handler;
  sigaction(signal, &action, nullptr);
}

}  // namespace

void install_stop_handlers() {
  for (const int signal : {SIGINT, SIGTERM}) set_action(signal, on_signal);
  for (const int signal : {SIGHUP, SIGQUIT, SIGXCPU}) {
    struct sigaction inherited = {};
    sigaction(signal, nullptr, &inherited);
    // Keep ignoring signals that were ignored at the start, as under nohup or in a background job.
    if (inherited.sa_handler != SIG_IGN) set_action(signal, on_signal);
  }
  set_action(SIGUSR1, on_checkpoint_signal);
  for (const int signal : {SIGPIPE, SIGXFSZ}) set_action(signal, SIG_IGN);
}

bool stop_signalled() { return g_signal_count > 0; }

bool take_checkpoint_request() { return g_checkpoint_requested.exchange(0) != 0; }

GracefulStop::GracefulStop() { g_is_graceful = 1; }

GracefulStop::~GracefulStop() { g_is_graceful = 0; }

}  // namespace emberline
