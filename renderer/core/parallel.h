// TBB's loops as this project uses them. They return when every call has; the first exception
// thrown in one ends the loop and is thrown again here. Called from any thread, may be nested.
//
// The only way into them, so that ThreadSanitizer learns what is ordered (see parallel.cpp). One
// call through a pointer per part, not per index.
#pragma once

#include <cstddef>

namespace emberline::parallel_detail {

enum class Split { kAsTbbLikes, kToTheGrain };

void run(size_t count, size_t grain, Split split,
         void (*call)(const void* body, size_t begin, size_t end), const void* body);

}  // namespace emberline::parallel_detail

namespace emberline {

// body(begin, end) for parts of [0, count); TBB chooses them, and splits none of `grain` indices or
// fewer.
template <typename Body>
void parallel_ranges(size_t count, size_t grain, const Body& body) {
  const auto call = [](const void* erased, size_t begin, size_t end) {
    (*static_cast<const Body*>(erased))(begin, end);
  };
  parallel_detail::run(count, grain, parallel_detail::Split::kAsTbbLikes, call, &body);
}

// body(i) for each i below count, in parts that TBB chooses.
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

// body(i) for each i below count, each a task of its own: for few and long ones.
template <typename Body>
void parallel_tasks(size_t count, const Body& body) {
  const auto call = [](const void* erased, size_t begin, size_t) {
    (*static_cast<const Body*>(erased))(begin);
  };
  parallel_detail::run(count, 1, parallel_detail::Split::kToTheGrain, call, &body);
}

}  // namespace emberline
