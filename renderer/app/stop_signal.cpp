#include "renderer/app/stop_signal.h"

#include <unistd.h>

#include <csignal>

#include "io/atomic_file.h"
#include "renderer/core/errors.h"

namespace emberline {
namespace {

volatile std::sig_atomic_t g_signals = 0;
volatile std::sig_atomic_t g_graceful = 0;

void on_signal(int) {
  g_signals = g_signals + 1;
  if (g_graceful && g_signals == 1) return;
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
