// Parallel loops built on TBB. A loop returns when every call of its body has returned. The first
// exception that the body throws ends the loop and is rethrown to the caller. The loops may be
// called from any thread and may be nested.
//
// All code must use these instead of TBB, so that ThreadSanitizer sees which code happens before
// which (see parallel.cpp). A loop costs one indirect call per range, not per index.
#pragma once

#include <cstddef>

namespace emberline::parallel_detail {

enum class Partitioner { kAuto, kSimple };

void run(size_t count, size_t grain, Partitioner partitioner,
         void (*call)(const void* body, size_t begin, size_t end), const void* body);

}  // namespace emberline::parallel_detail

namespace emberline {

// Returns the greatest number of threads that a loop of the caller can run on.
size_t worker_count();

// Calls body(begin, end) for ranges that together cover [0, count). TBB chooses the ranges; it does
// not split a range of `grain` or fewer indices.
template <typename Body>
void parallel_ranges(size_t count, size_t grain, const Body& body) {
  const auto call = [](const void* erased, size_t begin, size_t end) {
    (*static_cast<const Body*>(erased))(begin, end);
  };
  parallel_detail::run(count, grain, parallel_detail::Partitioner::kAuto, call, &body);
}

// Calls body(i) for each i < count. TBB divides the indices into ranges as in parallel_ranges().
template <typename Body>
void parallel_each(size_t count, size_t grain, const Body& body) {
  parallel_ranges(count, grain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) body(i);
  });
}
template <typename Body>
void parallel_each(size_t count, const Body& body) {
  parallel_each(count, 1, body);
}

// Calls body(y) for each row of an image.
template <typename Body>
void for_each_row(int height, const Body& body) {
  parallel_each(size_t(height > 0 ? height : 0), [&](size_t y) { body(int(y)); });
}

// Calls body(i) for each i < count, each in a separate task. Use this for a small number of long
// calls.
template <typename Body>
void parallel_tasks(size_t count, const Body& body) {
  const auto call = [](const void* erased, size_t begin, size_t) {
    (*static_cast<const Body*>(erased))(begin);
  };
  parallel_detail::run(count, 1, parallel_detail::Partitioner::kSimple, call, &body);
}

}  // namespace emberline
