// A frame's workers, and what they count. Private to render_job.cpp and render_tiles.cpp.
#pragma once

#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <stop_token>
#include <utility>

#include "renderer/core/parallel.h"
#include "renderer/engine/render_worker.h"
#include "renderer/engine/shared_tiles.h"

namespace emberline {

inline size_t worker_count() {
  return size_t(std::max(1, tbb::this_task_arena::max_concurrency()));
}

class RenderLoop {
 public:
  RenderLoop(const Frame& frame, RenderSink& the_sink, std::stop_token the_stop,
             RenderCounters& counters)
      : sink(the_sink), stop(std::move(the_stop)), frame_(frame), counters_(counters) {}

  // work(worker, going) in as many threads as there are, or `most`; going() is false once one of
  // them has thrown, or a stop is requested. Rethrows.
  template <typename Work>
  void share(size_t most, const Work& work) {
    std::atomic<bool> failed{false};
    const auto going = [&] {
      return !failed.load(std::memory_order_relaxed) && !stop.stop_requested();
    };
    parallel_tasks(std::min(most, worker_count()), [&](size_t) {
      try {
        RenderWorker worker(frame_);
        work(worker, going);
        count(worker.take_counters());
      } catch (...) {
        failed = true;  // the others need not finish a frame that is lost
        throw;
      }
    });
  }

  void count(const RenderCounters& more) {
    const std::lock_guard lock(mutex_);
    counters_.merge(more);
  }

  RenderSink& sink;
  const std::stop_token stop;

 private:
  const Frame& frame_;
  RenderCounters& counters_;
  std::mutex mutex_;
};

// Puts the driver's own picture into the film, where it is another than the film's means.
void show_picture(const FrameDriver& driver, FilmTile& film);

}  // namespace emberline
