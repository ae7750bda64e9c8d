#include "renderer/engine/worker_threads.h"

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/resource.h>
#include <tbb/task_arena.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <iterator>
#include <thread>

#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/core/parallel.h"

namespace emberline {
namespace {

// Becomes a user who may start `more` threads in addition to those that libraries have started.
void limit_threads(rlim_t more) {
  const std::filesystem::directory_iterator threads("/proc/self/task");
  const auto there = rlim_t(std::distance(begin(threads), end(threads)));
  const rlimit limit = {there + more, there + more};
  ASSERT_EQ(::setrlimit(RLIMIT_NPROC, &limit), 0);
  ASSERT_EQ(::setuid(200000 + uid_t(::getpid())), 0);
}

TEST(WorkerThreads, StartsTheRequestedNumber) {
  EXPECT_EQ(WorkerThreads(3).count(), 3);
  EXPECT_EQ(WorkerThreads(0).count(), usable_processors());
}

// taskset, containers and batch systems set this mask for a thread and its children.
TEST(WorkerThreads, TheAffinityMaskCounts) {
  cpu_set_t before;
  ASSERT_EQ(sched_getaffinity(0, sizeof before, &before), 0);
  EXPECT_EQ(usable_processors(), CPU_COUNT(&before));
  cpu_set_t some;
  CPU_ZERO(&some);
  for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
    if (!CPU_ISSET(cpu, &before)) continue;
    CPU_SET(cpu, &some);
    ASSERT_EQ(sched_setaffinity(0, sizeof some, &some), 0);
    EXPECT_EQ(usable_processors(), CPU_COUNT(&some));
    EXPECT_EQ(WorkerThreads(0).count(), CPU_COUNT(&some));
    EXPECT_EQ(WorkerThreads(2).count(), 2) << "what is asked for is given";
    if (CPU_COUNT(&some) == 2) break;
  }
  ASSERT_EQ(sched_setaffinity(0, sizeof before, &before), 0);
}

// The refused thread may be the second, which work waits for, or one of TBB's own. In both cases
// the error is one line.
TEST(WorkerThreads, AThreadThatTbbIsRefusedIsOneLine) {
  if (::getuid() != 0) GTEST_SKIP() << "limits count all that a user runs; root can become another";
  ::testing::GTEST_FLAG(death_test_style) = "threadsafe";
  const auto use_eight = [](rlim_t more) {
    install_refused_thread_handler();
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 8);
    limit_threads(more);
    tbb::task_arena arena(8);
    try {
      arena.execute([] {
        parallel_tasks(64,
                       [](size_t) { std::this_thread::sleep_for(std::chrono::milliseconds(50)); });
      });
    } catch (const std::exception& error) {
      log_error(message_of(error));
      ::_exit(kExitRenderFailed);
    }
  };
  for (const rlim_t more : {1, 2}) {
    EXPECT_EXIT(use_eight(more), ::testing::ExitedWithCode(kExitRenderFailed),
                "^emberline: error: .*lower threads\n$");
  }
}

}  // namespace
}  // namespace emberline
