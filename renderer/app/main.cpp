#include <exception>
#include <new>

#include "renderer/app/command_line.h"
#include "renderer/app/standard_output.h"
#include "renderer/app/stop_signal.h"
#include "renderer/app/worker_threads.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"

int main(int argc, char** argv) {
  using namespace emberline;
  replace_closed_streams();
  install_stop_handlers();
  install_refused_thread_handler();
  try {
    return run_command_line(argc, argv);
  } catch (const EmberlineError& error) {
    log_error(error.what());
    return error.exit_code();
  } catch (const std::bad_alloc&) {
    log_error("out of memory; render a smaller frame (--size, --crop) or fewer textures");
    return kExitRenderFailed;
  } catch (const std::exception& error) {
    log_error(message_of(error));
    return kExitRenderFailed;
  }
}
