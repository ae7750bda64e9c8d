#include "renderer/engine/worker_threads.h"

#include <fmt/format.h>
#include <pthread.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <latch>
#include <string_view>
#include <system_error>
#include <thread>
#include <vector>

#include "io/files/atomic_file.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/engine/process_usage.h"

namespace emberline {
namespace {

// Threads in addition to the workers: progress display, connection to a viewer, and libraries.
constexpr int kOtherThreads = 4;

constexpr const char* kThreadLimitHint =
    "(check ulimit -u, the container's process limit and free memory)";

// Returns how many further threads the system can start, up to `requested`, with TBB's stack size.
int count_startable(int requested) {
  std::latch end(1);
  std::vector<pthread_t> threads;
  threads.reserve(size_t(requested));
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(
      &attributes, tbb::global_control::active_value(tbb::global_control::thread_stack_size));
  const auto wait = [](void* latch) -> void* {
    static_cast<std::latch*>(latch)->wait();
    return nullptr;
  };
  pthread_t thread = {};
  while (int(threads.size()) < requested && pthread_create(&thread, &attributes, wait, &end) == 0) {
    threads.push_back(thread);
  }
  pthread_attr_destroy(&attributes);
  end.count_down();
  for (const pthread_t started : threads) pthread_join(started, nullptr);
  return int(threads.size());
}

int choose_count(int requested) {
  int count = requested;
  if (requested == 0) {
    count = usable_processors();
    if (const auto cpus = slurm_cpus(); cpus && *cpus <= count) {
      log_verbose(fmt::format("`threads` {}: SLURM_CPUS_PER_TASK", *cpus));
      count = *cpus;
    }
  }
  // The calling thread counts as a worker.
  const int startable = 1 + count_startable(count - 1 + kOtherThreads) - kOtherThreads;
  if (startable >= count) return count;
  if (startable < 1) {
    throw RenderError("the system allows too few threads to run at all {}; raise the limit",
                      kThreadLimitHint);
  }
  if (requested > 0) {
    throw RenderError("`threads` {}: the system allows at most {} {}; lower `threads`", requested,
                      startable, kThreadLimitHint);
  }
  log_warning(fmt::format("using only {} of {} cores: the system allows no more threads {}",
                          startable, count, kThreadLimitHint));
  return startable;
}

std::terminate_handler g_previous_handler = nullptr;

bool is_refused_thread(const std::exception& error) {
  if (const auto* system = dynamic_cast<const std::system_error*>(&error)) {
    return system->code() == std::errc::resource_unavailable_try_again;  // from std::thread
  }
  return std::string_view(error.what()).find("pthread_create") !=
         std::string_view::npos;  // from TBB
}

[[noreturn]] void on_terminate() {
  try {
    if (const std::exception_ptr error = std::current_exception()) std::rethrow_exception(error);
  } catch (const std::exception& error) {
    if (is_refused_thread(error)) {
      log_error(message_of(error));
      remove_unfinished_files();
      ::_exit(kExitRenderFailed);
    }
  } catch (...) {
  }
  if (g_previous_handler) g_previous_handler();
  std::abort();
}

}  // namespace

int usable_processors() {
  // A machine may have more processors than a cpu_set_t has bits. In that case, the call fails with
  // EINVAL and is repeated with a larger mask.
  for (size_t bits = CPU_SETSIZE; bits <= size_t(1) << 20; bits *= 2) {
    std::vector<cpu_set_t> mask(bits / CPU_SETSIZE);
    const size_t bytes = mask.size() * sizeof(cpu_set_t);
    if (sched_getaffinity(0, bytes, mask.data()) == 0) {
      return std::max(1, CPU_COUNT_S(bytes, mask.data()));
    }
    if (errno != EINVAL) break;
  }
  return int(std::max(1u, std::thread::hardware_concurrency()));
}

void install_refused_thread_handler() { g_previous_handler = std::set_terminate(on_terminate); }

std::string message_of(const std::exception& error) {
  if (!is_refused_thread(error)) return error.what();
  return fmt::format("the system allows no more threads {}; lower `threads`", kThreadLimitHint);
}

WorkerThreads::WorkerThreads(int requested)
    : count_(choose_count(requested)),
      limit_(tbb::global_control::max_allowed_parallelism, size_t(count_)) {}

}  // namespace emberline
