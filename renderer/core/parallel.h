// TBB's loops as this project uses them. They return when every call has; the first exception
// thrown in one ends the loop and is thrown again here. Called from any thread, may be nested.
//
// They are here for the sake of ThreadSanitizer: what came before a loop happens before its body,
// and the body before what comes after, but TBB says so in its library, which distributions do not
// instrument. Without these lines every loop reports races, and a suppression that silenced them
// would hide the true ones, since all our threads are TBB's. In other builds LoopOrder is empty.
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/partitioner.h>

#include <cstddef>

#if defined(__SANITIZE_THREAD__)
#define EMBERLINE_THREAD_SANITIZER 1
#elif defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define EMBERLINE_THREAD_SANITIZER 1
#endif
#endif

#ifdef EMBERLINE_THREAD_SANITIZER
#include <sanitizer/tsan_interface.h>
#endif

namespace emberline::parallel_detail {

#ifdef EMBERLINE_THREAD_SANITIZER
// Constructed before the loop, destroyed after it.
class LoopOrder {
 public:
  LoopOrder() { __tsan_release(&begin_); }
  ~LoopOrder() { __tsan_acquire(&end_); }
  LoopOrder(const LoopOrder&) = delete;
  LoopOrder& operator=(const LoopOrder&) = delete;

  // Around one call of the body.
  class Body {
   public:
    explicit Body(LoopOrder& order) : order_(order) { __tsan_acquire(&order_.begin_); }
    ~Body() { __tsan_release(&order_.end_); }
    Body(const Body&) = delete;
    Body& operator=(const Body&) = delete;

   private:
    LoopOrder& order_;
  };

 private:
  char begin_ = 0, end_ = 0;  // their addresses are what counts
};
#else
struct LoopOrder {
  struct Body {
    explicit Body(LoopOrder&) {}
  };
};
#endif

}  // namespace emberline::parallel_detail

namespace emberline {

// body(begin, end) for parts of [0, count); TBB chooses them, and splits none of `grain` indices or
// fewer.
template <typename Body>
void parallel_ranges(size_t count, size_t grain, const Body& body) {
  parallel_detail::LoopOrder order;
  tbb::parallel_for(tbb::blocked_range<size_t>(0, count, grain),
                    [&](const tbb::blocked_range<size_t>& range) {
                      const parallel_detail::LoopOrder::Body ordered(order);
                      body(range.begin(), range.end());
                    });
}

// body(i) for each i below count, in parts that TBB chooses.
template <typename Body>
void parallel_each(size_t count, const Body& body) {
  parallel_ranges(count, 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) body(i);
  });
}

// body(i) for each i below count, each a task of its own: for few and long ones.
template <typename Body>
void parallel_tasks(size_t count, const Body& body) {
  parallel_detail::LoopOrder order;
  tbb::parallel_for(
      tbb::blocked_range<size_t>(0, count, 1),
      [&](const tbb::blocked_range<size_t>& range) {
        const parallel_detail::LoopOrder::Body ordered(order);
        body(range.begin());
      },
      tbb::simple_partitioner());
}

}  // namespace emberline
