#include "renderer/engine/render_loop.h"

#include "renderer/film/film.h"

namespace emberline {

// Lists the pixels of a part and their samples, except the samples that the film already has. A
// pixel's sample count tells which samples these are, because samples are added in index order.
void RoundWork::expand(size_t part, std::vector<PixelWork>& list) const {
  list.clear();
  driver_.expand(part, list);
  if (!film_is_ahead_) return;
  for (PixelWork& work : list) {
    const uint32_t end = work.first_sample + work.sample_count;
    work.first_sample = std::clamp(film_.sample_count(work.x, work.y), work.first_sample, end);
    work.sample_count = end - work.first_sample;
  }
  std::erase_if(list, [](const PixelWork& work) { return work.sample_count == 0; });
}

void RoundWork::mark_interrupted(size_t part) {
  const std::lock_guard lock(mutex_);
  interrupted_.push_back(part);
}

RenderedParts RoundWork::rendered(bool stopped) const {
  const size_t begun = std::min(end_, next_.load());
  return {begin_, begun, interrupted_.empty() && (begun == end_ || !stopped), interrupted_};
}

TileOwner::TileOwner(SharedTiles& tiles) : tiles_(tiles) {
  const std::lock_guard lock(tiles_.mutex_);
  ++tiles_.owners_;
}

TileOwner::~TileOwner() {
  const std::lock_guard lock(tiles_.mutex_);
  --tiles_.owners_;
  tiles_.changed_.notify_all();
}

void TileOwner::execute(RoundWork& work, RenderWorker& worker, RenderCounters& counters) {
  SharedTiles::OpenRound round{work};
  {
    const std::lock_guard lock(tiles_.mutex_);
    tiles_.open_rounds_.push_back(&round);
    tiles_.changed_.notify_all();
  }
  const std::exception_ptr thrown = tiles_.take_parts(work, worker);
  std::unique_lock lock(tiles_.mutex_);
  std::erase(tiles_.open_rounds_, &round);
  tiles_.changed_.wait(lock, [&] { return round.helpers == 0; });
  lock.unlock();
  if (thrown || round.thrown) std::rethrow_exception(thrown ? thrown : round.thrown);
  counters.merge(round.counters);
}

void SharedTiles::help(RenderWorker& worker) {
  std::unique_lock lock(mutex_);
  while (owners_ > 0 && !stop_.stop_requested()) {
    OpenRound* const round = longest_round();
    if (!round) {
      changed_.wait(lock);
      continue;
    }
    ++round->helpers;
    lock.unlock();
    const std::exception_ptr thrown = take_parts(round->work, worker);
    lock.lock();  // once the lock is released, the owner may destroy `round`
    if (--round->helpers == 0) changed_.notify_all();
    if (thrown) {
      round->thrown = thrown;
    } else {
      round->counters.merge(worker.take_counters());
    }
  }
}

std::exception_ptr SharedTiles::take_parts(RoundWork& work, RenderWorker& worker) {
  try {
    work.take_parts(worker, sink_, stop_, [this] { return !stop_.stop_requested(); });
    return nullptr;
  } catch (...) {
    work.abandon();
    return std::current_exception();
  }
}

// Returns the open round with the most parts left, or null if no round has parts left.
SharedTiles::OpenRound* SharedTiles::longest_round() const {
  const auto longest = std::ranges::max_element(
      open_rounds_, {}, [](const OpenRound* round) { return round->work.parts_left(); });
  return longest != open_rounds_.end() && (*longest)->work.parts_left() > 0 ? *longest : nullptr;
}

}  // namespace emberline
