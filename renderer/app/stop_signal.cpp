#include "renderer/app/stop_signal.h"

#include <unistd.h>

#include <atomic>
#include <csignal>

#include "io/atomic_file.h"
#include "renderer/core/errors.h"

namespace emberline {
namespace {

// The handler runs on whichever thread the signal finds, while another asks: atomics, and lock-free
// ones, which a handler may touch.
std::atomic<int> g_signals{0};
std::atomic<int> g_graceful{0};
static_assert(std::atomic<int>::is_always_lock_free);

void on_signal(int) {
  const int count = ++g_signals;
  if (g_graceful != 0 && count == 1) return;
  remove_unfinished_files();
  _exit(kExitStopped);
}

void set_action(int signal, void (*handler)(int)) {
  struct sigaction action = {};
  action.sa_handler = handler;
  sigaction(signal, &action, nullptr);
}

}  // namespace

void install_stop_handlers() {
  set_action(SIGINT, on_signal);
  set_action(SIGTERM, on_signal);
  struct sigaction hangup = {};
  sigaction(SIGHUP, nullptr, &hangup);
  if (hangup.sa_handler != SIG_IGN) set_action(SIGHUP, on_signal);  // else: nohup means it
  set_action(SIGXFSZ, SIG_IGN);
}

bool stop_signalled() { return g_signals > 0; }

GracefulStop::GracefulStop() {
  set_action(SIGPIPE, SIG_IGN);
  g_graceful = 1;
}

GracefulStop::~GracefulStop() { g_graceful = 0; }

}  // namespace emberline
