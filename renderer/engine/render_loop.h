// Runs a frame's workers, adds up their counters, and lets them share tiles. Only render_job.cpp,
// render_tiles.cpp and shared_tiles.cpp include this file.
#pragma once

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <mutex>
#include <stop_token>
#include <utility>
#include <vector>

#include "renderer/core/parallel.h"
#include "renderer/drivers/frame.h"
#include "renderer/drivers/frame_driver.h"
#include "renderer/engine/render_sink.h"
#include "renderer/engine/render_worker.h"

namespace emberline {

class RenderLoop {
 public:
  RenderLoop(const Frame& frame, RenderSink& the_sink, std::stop_token the_stop,
             RenderCounters& counters)
      : sink(the_sink), stop(std::move(the_stop)), frame_(frame), counters_(counters) {}

  // Runs work(worker, should_continue) on all threads, but on no more than `max_threads`.
  // should_continue() returns false once a worker has thrown or a stop is requested. Rethrows what
  // a worker throws.
  template <typename Work>
  void run_workers(size_t max_threads, const Work& work) {
    std::atomic<bool> failed{false};
    const auto should_continue = [&] {
      return !failed.load(std::memory_order_relaxed) && !stop.stop_requested();
    };
    parallel_tasks(std::min(max_threads, worker_count()), [&](size_t) {
      try {
        RenderWorker worker(frame_);
        work(worker, should_continue);
        count(worker.take_counters());
      } catch (...) {
        failed = true;  // tells the other workers to end
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

// If the picture that the driver shows differs from the film's means, writes the shown values into
// the film.
void store_driver_picture(const FrameDriver& driver, FilmTile& film);

// The parts of one round. Any number of workers take them in order.
class RoundWork {
 public:
  // Hands out parts [begin, end). If `film_is_ahead` is set, pixels may already have some of the
  // samples of these parts.
  RoundWork(const FrameDriver& driver, FilmTile& film, size_t begin, size_t end, bool film_is_ahead)
      : driver_(driver),
        film_(film),
        film_is_ahead_(film_is_ahead),
        seed_(driver.round().seed),
        begin_(begin),
        end_(end),
        next_(begin) {}

  // Renders parts while any are left and should_continue() is true. Called from several threads,
  // each with its own worker.
  template <typename Condition>
  void take_parts(RenderWorker& worker, RenderSink& sink, const std::stop_token& stop,
                  const Condition& should_continue) {
    std::vector<PixelWork> list;
    worker.set_seed(seed_);
    while (should_continue()) {
      const size_t part = next_.fetch_add(1, std::memory_order_relaxed);
      if (part >= end_) break;
      expand(part, list);
      if (!worker.render(list, film_, sink, stop)) mark_interrupted(part);
    }
  }

  // Stops handing out parts, because the frame has failed.
  void abandon() { next_.store(end_, std::memory_order_relaxed); }

  size_t parts_left() const { return end_ - std::min(end_, next_.load(std::memory_order_relaxed)); }
  // Must be called after all workers have returned, but not after abandon(). If parts are left,
  // `stopped` must be true after a stop request and false at a pause.
  RenderedParts rendered(bool stopped) const;

 private:
  void expand(size_t part, std::vector<PixelWork>& list) const;
  void mark_interrupted(size_t part);

  const FrameDriver& driver_;
  FilmTile& film_;
  const bool film_is_ahead_;
  const uint32_t seed_;
  const size_t begin_, end_;
  std::atomic<size_t> next_;
  std::mutex mutex_;
  std::vector<size_t> interrupted_;
};

// Shares the last tiles of a frame. A worker that finds no tile left helps with the rounds of other
// workers' tiles, so that no thread is idle while the most expensive tile is finished.
class SharedTiles {
 public:
  SharedTiles(RenderSink& sink, const std::stop_token& stop) : sink_(sink), stop_(stop) {}

  // Helps the owners of tiles until no owner is left or a stop is requested. Must not be called by
  // an owner.
  void help(RenderWorker& worker);

 private:
  friend class TileOwner;
  struct OpenRound {
    RoundWork& work;
    int helpers = 0;
    RenderCounters counters = {};    // counts of the helpers
    std::exception_ptr thrown = {};  // the last exception of a helper
  };

  OpenRound* longest_round() const;
  // If rendering a part throws, abandons the round and returns the exception.
  std::exception_ptr take_parts(RoundWork& work, RenderWorker& worker);

  RenderSink& sink_;
  const std::stop_token& stop_;
  std::mutex mutex_;
  std::condition_variable changed_;
  int owners_ = 0;
  std::vector<OpenRound*> open_rounds_;
};

// Marks a worker as an owner of tiles during its lifetime.
class TileOwner {
 public:
  explicit TileOwner(SharedTiles& tiles);
  ~TileOwner();
  TileOwner(const TileOwner&) = delete;
  TileOwner& operator=(const TileOwner&) = delete;

  // Renders the round together with helpers. Adds the helpers' counts to `counters`. Returns after
  // all helpers have finished. If one of the threads throws, no further part begins and execute()
  // rethrows the exception.
  void execute(RoundWork& work, RenderWorker& worker, RenderCounters& counters);

 private:
  SharedTiles& tiles_;
};

}  // namespace emberline
