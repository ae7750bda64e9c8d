// The member functions of RenderJob that only tiled drivers need.
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "renderer/core/errors.h"
#include "renderer/drivers/bucket_schedule.h"
#include "renderer/engine/render_clock.h"
#include "renderer/engine/render_job.h"
#include "renderer/engine/render_loop.h"
#include "renderer/engine/time_budget.h"
#include "renderer/film/film.h"

namespace emberline {

void TileResult::archive(Archive& archive) {
  double value = error.value_or(-1.0);
  archive.number(value, -1.0, std::numeric_limits<double>::max());
  archive.check(value == -1.0 || value >= 0.0);
  error = value >= 0.0 ? std::optional(value) : std::nullopt;
  archive.number(min_samples, 0u, UINT32_MAX);
  counters.archive(archive);
}

std::optional<double> error_of_tiles(std::span<const Rect> tiles,
                                     std::span<const std::optional<double>> errors) {
  double sum = 0, pixels = 0;
  for (size_t i = 0; i < tiles.size(); ++i) {
    if (!errors[i]) return std::nullopt;
    sum += square(*errors[i]) * double(tiles[i].area());
    pixels += double(tiles[i].area());
  }
  return tiles.empty() ? std::nullopt : std::optional(std::sqrt(sum / pixels));
}

namespace {

// A sink for samples that only measure the speed. It ignores them.
class SilentSink final : public RenderSink {
 public:
  void tile_finished(const FilmTile&) override {}
};

uint64_t pixels_of(std::span<const Rect> tiles) {
  uint64_t pixels = 0;
  for (const Rect& tile : tiles) pixels += uint64_t(tile.area());
  return pixels;
}

}  // namespace

void RenderJob::render_tile(RenderLoop& loop, TileOwner& owner, RenderWorker& worker,
                            FrameDriver& driver, FilmTile& film, TileResult& result) {
  const bool film_is_ahead = result.counters.samples > 0;
  for (bool complete = true; complete;) {
    const std::optional<Round> round = driver.next(film, {});
    if (!round) break;
    RoundWork work(driver, film, 0, round->parts, film_is_ahead);
    owner.execute(work, worker, result.counters);
    const RenderedParts parts = work.rendered(loop.stop.stop_requested());
    driver.rendered(parts, film);
    complete = parts.complete;
  }
  driver.end(film, loop.sink.stop_cause());
  store_driver_picture(driver, film);
  result.counters.merge(worker.take_counters());
  result.error = driver.error_estimate();
  result.min_samples = driver.min_samples(film);
}

// Measures the cost of each tile: renders `samples` samples, from `first_sample` on, of a few of
// its pixels.
void RenderJob::measure_tiles(RenderLoop& loop, std::span<const Rect> tiles, uint32_t first_sample,
                              uint32_t samples, std::span<TileCost> costs) const {
  // Measures about kPixels pixels of a tile, or the share kShare of a small tile.
  constexpr double kPixels = 128, kShare = 1.0 / 32;
  std::atomic<size_t> next{0};
  SilentSink sink;
  loop.run_workers(tiles.size(), [&](RenderWorker& worker, const auto& should_continue) {
    FilmTile film(frame_.aovs, film_extras());
    std::vector<PixelWork> list;
    while (should_continue()) {
      const size_t i = next.fetch_add(1, std::memory_order_relaxed);
      if (i >= tiles.size()) break;
      const Rect& tile = tiles[i];
      const double pixels = std::min(kPixels, kShare * double(tile.area()));
      const int step = std::max(1, int(std::sqrt(double(tile.area()) / pixels)));
      list.clear();
      for (int y = tile.y0 + step / 2; y < tile.y1; y += step) {
        for (int x = tile.x0 + step / 2; x < tile.x1; x += step) {
          list.push_back({x, y, first_sample, samples});
        }
      }
      if (list.empty()) list.push_back({tile.x0, tile.y0, first_sample, samples});
      film.reset(tile);
      worker.take_counters();
      const Stopwatch watch;
      worker.render(list, film, sink, loop.stop);
      const double seconds = watch.seconds();
      const RenderCounters counters = worker.take_counters();  // not added to the frame's
      const double per_sample =
          double(tile.area()) / double(std::max<uint64_t>(1, counters.samples));
      costs[i].add(per_sample * work_of(counters.rays), per_sample * seconds);
    }
  });
}

// Measures three times, because the first samples are slower than later ones, and then continues
// until kMinTime is over. The times are fractions of the time budget. A single measurement costs
// about as much as a sixth of a sample in every pixel.
void RenderJob::begin_budget(RenderLoop& loop, std::span<const Rect> tiles,
                             std::optional<TileBudget>& budget) const {
  constexpr uint32_t kSamples = 4, kMinSamplesPerPixel = 12, kMaxSamplesPerPixel = 96;
  constexpr double kMinTime = 0.01, kMaxTime = 0.04;
  const double seconds = frame_.time_budget_s;
  const Stopwatch watch;
  std::vector<TileCost> costs(tiles.size());
  for (uint32_t done = 0; done < kMaxSamplesPerPixel && !loop.stop.stop_requested();
       done += kSamples) {
    const double limit = done < kMinSamplesPerPixel ? kMaxTime : kMinTime;
    if (done > 0 && watch.seconds() > limit * seconds) break;
    measure_tiles(loop, tiles, done, kSamples, costs);
  }
  // Rows of a tile are shared, so even a few tiles occupy all workers.
  const size_t rows = tiles.size() * size_t(drivers_.tile_size);
  const size_t workers = std::max<size_t>(1, std::min(rows, worker_count()));
  const double pauses = tile_pauses(costs);
  budget.emplace(
      seconds, [watch] { return watch.seconds(); }, tile_seconds(costs), pauses / double(workers),
      frame_.samples_per_pixel);
}

// Workers take the next tile from a counter, so that tiles begin in order, whatever the speed of
// the threads. A thread that owns tiles is isolated: while it waits for TBB during a driver's
// decision, it must not start work that waits for the thread's own tile.
void RenderJob::render_tiles(RenderLoop& loop) {
  const std::vector<Rect> tiles = this->tiles();
  std::atomic<size_t> next{0};
  std::atomic<bool> all_finished{true};
  std::atomic<uint64_t> sampled_pixels{0};
  std::vector<std::optional<double>> errors(tiles.size());  // by tile, to be summed in tile order
  std::vector<uint32_t> tile_min_samples(tiles.size(), 0);
  SharedTiles shared(loop.sink, loop.stop);
  std::optional<TileBudget> budget;
  if (frame_.time_budget_s > 0) begin_budget(loop, tiles, budget);
  const auto take_tiles = [&](RenderWorker& worker, const auto& should_continue) {
    TileOwner owner(shared);
    FilmTile film(frame_.aovs, film_extras());
    while (should_continue()) {
      const size_t n = next.fetch_add(1, std::memory_order_relaxed);
      if (n >= tiles.size()) break;
      const size_t i = budget ? budget->tile_at(n) : n;
      TileResult result{.counters = frame_.empty_counters()};
      if (load_tile(loop, tiles[i], film, result)) {
        if (budget) budget->skip(i);
      } else {
        loop.sink.tile_begun(tiles[i]);
        const uint32_t samples = budget ? budget->begin(i) : frame_.samples_per_pixel;
        const std::unique_ptr<FrameDriver> driver =
            begin_tile(loop, tiles[i], samples, film, result);
        render_tile(loop, owner, worker, *driver, film, result);
        if (!driver->finished()) all_finished = false;
        if (driver->finished() && store_) save_tile(*driver, film, result);
        loop.sink.tile_finished(film);
        if (budget) budget->end(i);
      }
      loop.count(result.counters);
      errors[i] = result.error;
      tile_min_samples[i] = result.min_samples;
      sampled_pixels += uint64_t(tiles[i].area()) - count_unsampled(film);
    }
  };
  // Starts up to one worker per row of pixels, because even a single row of a tile is worth
  // sharing.
  loop.run_workers(tiles.size() * size_t(drivers_.tile_size),
                   [&](RenderWorker& worker, const auto& should_continue) {
                     tbb::this_task_arena::isolate([&] { take_tiles(worker, should_continue); });
                     shared.help(worker);
                   });
  counters_.stopped = !all_finished || next.load() < tiles.size();
  counters_.min_samples = tiles.empty() ? 0 : *std::ranges::min_element(tile_min_samples);
  unsampled_pixels_ = pixels_of(tiles) - sampled_pixels.load();
  tile_error_ = error_of_tiles(tiles, errors);
}

// Returns the tiles of this part of the frame, in render order.
std::vector<Rect> RenderJob::tiles() const {
  const std::vector<Rect> all =
      bucket_schedule(frame_.crop, drivers_.tile_size, drivers_.tile_order, frame_.seed);
  std::vector<Rect> tiles;
  for (size_t i = drivers_.part.index - 1; i < all.size(); i += drivers_.part.count) {
    tiles.push_back(all[i]);
  }
  return tiles;
}

void RenderJob::save_tile(FrameDriver& driver, FilmTile& film, TileResult& result) {
  std::vector<std::byte> state;
  state.reserve(film.bytes() + driver.bytes() + 4096);
  Archive saving(state);
  result.archive(saving);
  film.archive(saving);
  driver.archive(saving, film);
  store_->save(bucket_index(frame_.crop, film.rect(), drivers_.tile_size), state);
}

// Creates the tile's driver. If this frame extends another frame, and that frame has a usable state
// for the tile, starts from that state.
std::unique_ptr<FrameDriver> RenderJob::begin_tile(RenderLoop& loop, const Rect& tile,
                                                   uint32_t samples, FilmTile& film,
                                                   TileResult& result) {
  film.reset(tile);
  Frame frame = frame_;
  frame.samples_per_pixel = samples;
  std::unique_ptr<FrameDriver> driver = drivers_.create(frame, tile);
  if (!store_) return driver;
  const auto finished = store_->load_finished(bucket_index(frame_.crop, tile, drivers_.tile_size),
                                              TileStore::max_state_bytes(film.bytes()));
  if (!finished) return driver;
  try {
    Archive loading{std::span<const std::byte>(*finished)};
    result.archive(loading);
    film.archive(loading);
    film.clear_overrides();
    driver->extend(loading, film);
  } catch (const InputError&) {
    store_->report_unusable(true);
    result = {.counters = frame_.empty_counters()};
    film.reset(tile);
    return drivers_.create(frame, tile);
  }
  loop.sink.samples_loaded(result.counters.samples);
  return driver;
}

// Returns false if the tile must be rendered. An unusable stored tile counts as missing.
bool RenderJob::load_tile(RenderLoop& loop, const Rect& tile, FilmTile& film, TileResult& result) {
  if (!store_) return false;
  film.reset(tile);
  const auto state = store_->load(bucket_index(frame_.crop, tile, drivers_.tile_size),
                                  TileStore::max_state_bytes(film.bytes()));
  if (!state) return false;
  try {
    Archive loading{std::span<const std::byte>(*state)};
    result.archive(loading);
    film.archive(loading);
    const std::unique_ptr<FrameDriver> driver = drivers_.create(frame_, tile);
    driver->archive(loading, film);
    loading.check(driver->finished());
    loading.end();
  } catch (const InputError&) {
    store_->report_unusable(false);
    result = {.counters = frame_.empty_counters()};
    return false;
  }
  loop.sink.tile_loaded(film, result.counters.samples);
  return true;
}

}  // namespace emberline
