#include "renderer/app/view/polite_workers.h"

#if defined(__linux__)
#include <sys/resource.h>
#include <unistd.h>
#endif

namespace emberline {
namespace {

void lower_priority() {
#if defined(__linux__)
  // Chosen by measurement (README.md): a tenth of the processor beside a thread that has its
  // ordinary priority, all of it beside none.
  constexpr int kNice = 10;
  const auto thread = id_t(gettid());
  if (getpriority(PRIO_PROCESS, thread) < kNice) {
    (void)setpriority(PRIO_PROCESS, thread, kNice);
  }
#endif
}

}  // namespace

PoliteWorkers::PoliteWorkers(tbb::task_arena& arena) : task_scheduler_observer(arena) {
  observe(true);
}

PoliteWorkers::~PoliteWorkers() { observe(false); }

void PoliteWorkers::on_scheduler_entry(bool /*worker*/) { lower_priority(); }

}  // namespace emberline
