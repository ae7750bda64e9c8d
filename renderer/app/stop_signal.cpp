#include "renderer/app/stop_signal.h"

#include <csignal>

#include "renderer/core/errors.h"

#include <unistd.h>

namespace emberline {
namespace {

volatile std::sig_atomic_t g_signals = 0;

void on_signal(int) {
  g_signals = g_signals + 1;
  if (g_signals > 1) _exit(kExitStopped);
}

}  // namespace

void install_stop_handlers() {
  struct sigaction action = {};
  action.sa_handler = on_signal;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

bool stop_signalled() { return g_signals > 0; }

}  // namespace emberline
