// Tells ThreadSanitizer about the order that TBB's loops impose: code before a loop happens before
// the loop's body, and the body happens before the code after the loop. The synchronisation is
// inside the TBB library, which distributions ship without instrumentation, so ThreadSanitizer
// would report every loop as a race. Suppressing reports about TBB would also hide real races,
// since all our threads are TBB's. Therefore this file declares the order explicitly. It is the
// only file that instantiates TBB's templates, and it is not instrumented
// (renderer/core/CMakeLists.txt).
#include "renderer/core/parallel.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/partitioner.h>
#include <tbb/task_arena.h>

#include <algorithm>

#ifdef EMBERLINE_THREAD_SANITIZER
#include <sanitizer/tsan_interface.h>
#endif

namespace emberline::parallel_detail {
namespace {

#ifdef EMBERLINE_THREAD_SANITIZER
// Declares the order of a loop. It uses separate addresses for the begin and the end, so that calls
// of the body are not ordered with respect to each other.
class LoopOrder {
 public:
  LoopOrder() { __tsan_release(&begin_); }
  ~LoopOrder() { __tsan_acquire(&end_); }
  LoopOrder(const LoopOrder&) = delete;
  LoopOrder& operator=(const LoopOrder&) = delete;

  class Call {
   public:
    explicit Call(LoopOrder& order) : order_(order) { __tsan_acquire(&order_.begin_); }
    ~Call() { __tsan_release(&order_.end_); }
    Call(const Call&) = delete;
    Call& operator=(const Call&) = delete;

   private:
    LoopOrder& order_;
  };

 private:
  char begin_ = 0, end_ = 0;
};
#else
struct LoopOrder {
  struct Call {
    explicit Call(LoopOrder&) {}
  };
};
#endif

}  // namespace

void run(size_t count, size_t grain, Partitioner partitioner,
         void (*call)(const void* body, size_t begin, size_t end), const void* body) {
  LoopOrder order;
  const tbb::blocked_range<size_t> all(0, count, grain);
  const auto part = [&](const tbb::blocked_range<size_t>& range) {
    const LoopOrder::Call ordered(order);
    call(body, range.begin(), range.end());
  };
  if (partitioner == Partitioner::kSimple) {
    tbb::parallel_for(all, part, tbb::simple_partitioner());
  } else {
    tbb::parallel_for(all, part);
  }
}

}  // namespace emberline::parallel_detail

namespace emberline {

size_t worker_count() { return size_t(std::max(1, tbb::this_task_arena::max_concurrency())); }

}  // namespace emberline
