#include "renderer/drivers/frame_film.h"

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <new>

#include "renderer/core/errors.h"
#include "renderer/core/parallel.h"
#include "renderer/drivers/bucket_driver.h"
#include "renderer/drivers/render_work_item.h"

namespace emberline {

SliceRunner::SliceRunner(const Frame& frame, FilmTile& film, FrameObserver& observer,
                         std::stop_token stop)
    : frame_(frame), film_(film), observer_(observer), stop_(std::move(stop)), seed_(frame.seed) {}

bool SliceRunner::run(size_t parts, const Expand& expand) {
  carry_out(parts, expand, false);
  return !counters_.stopped;
}

bool SliceRunner::run_until_wanted(size_t& parts, const Expand& expand) {
  parts = carry_out(parts, expand, true);
  return !counters_.stopped;
}

std::optional<uint64_t> SliceRunner::samples_until_wanted() const {
  const std::optional<uint64_t> wanted = observer_.picture_wanted_at();
  if (!wanted) return std::nullopt;
  return *wanted > counters_.samples ? *wanted - counters_.samples : 1;
}

// How many parts were begun, each of which is done unless a stop was requested.
size_t SliceRunner::carry_out(size_t parts, const Expand& expand, bool until_wanted) {
  cut_short_.clear();
  std::atomic<size_t> next{0};
  std::atomic<bool> failed{false};
  const auto work = [&] {
    try {
      RenderWorker worker(frame_);
      worker.set_seed(seed_);
      std::vector<PixelWork> list;
      std::optional<size_t> cut_short;
      while (!failed.load(std::memory_order_relaxed) && !stop_.stop_requested()) {
        const size_t part = next.fetch_add(1, std::memory_order_relaxed);
        if (part >= parts) break;
        list.clear();
        expand(part, list);
        if (!worker.render(list, film_, observer_, stop_)) cut_short = part;
        if (until_wanted && observer_.picture_wanted()) break;
      }
      const std::lock_guard lock(mutex_);
      counters_.merge(worker.counters());
      if (cut_short) cut_short_.push_back(*cut_short);
    } catch (...) {
      failed = true;
      throw;
    }
  };
  const int workers = std::max(1, tbb::this_task_arena::max_concurrency());
  parallel_tasks(std::min(parts, size_t(workers)), [&](size_t) { work(); });
  const size_t begun = std::min(parts, next.load());
  if (begun < parts && stop_.stop_requested()) counters_.stopped = true;
  return begun;
}

uint64_t film_bytes_per_pixel(const AovSet& aovs, const FilmExtras& extras) {
  FilmTile pixel(aovs, extras);
  pixel.reset({0, 0, 1, 1});
  return pixel.bytes() + 4 * sizeof(float);
}

void reset_film(const Rect& window, FilmTile* film) {
  try {
    film->reset(window);
  } catch (const std::bad_alloc&) {
    throw RenderError(
        fmt::format("not enough memory to hold a film of {}x{} pixels; --driver bucket needs no "
                    "more for a larger frame",
                    window.width(), window.height()));
  }
}

namespace {

// What each light group gives to each pixel of an incomplete picture, by pixel, then by group.
std::vector<Rgb> shown_lights(const FramePicture& picture, size_t groups) {
  const auto pixels = size_t(picture.film().rect().area());
  std::vector<Rgb> lights(groups * pixels);
  std::vector<float> rgba(4 * pixels);
  for (size_t g = 0; g < groups; ++g) {
    std::vector<Rgb> weights(groups, Rgb(0.0f));
    weights[g] = Rgb(1.0f);
    const LightMix alone(weights);
    picture.resolve(rgba, &alone);
    for (size_t i = 0; i < pixels; ++i) std::copy_n(&rgba[4 * i], 3, &lights[groups * i + g].x);
  }
  return lights;
}

}  // namespace

void deliver_film(const FramePicture& picture, int tile_size, FrameObserver& observer,
                  bool all_shown) {
  const FilmTile& film = picture.film();
  const Rect& window = film.rect();
  const std::vector<WorkItem> tiles =
      bucket_schedule(window, tile_size, BucketOrder::kScanline, 0, 0);
  // Before the workers begin: one that waits for help with it must not begin a tile that needs it.
  std::vector<float> shown;
  if (all_shown || film.least_samples() == 0) {
    shown.resize(4 * size_t(window.area()));
    picture.resolve(shown);
  }
  const auto groups = size_t(std::max(0, film.extras().light_groups));
  std::vector<Rgb> lights;
  if (!all_shown && !shown.empty() && groups > 0) lights = shown_lights(picture, groups);
  std::atomic<size_t> next{0};
  const auto work = [&](size_t /*worker*/) {
    FilmTile tile(film.aovs(), film.extras());  // one each: its memory serves again and again
    for (size_t i = next++; i < tiles.size(); i = next++) {
      const Rect& rect = tiles[i].pixels;
      tile.reset(rect);
      for (int y = rect.y0; y < rect.y1; ++y) {
        for (int x = rect.x0; x < rect.x1; ++x) {
          tile.copy_pixel(film, x, y);
          if (!all_shown && film.sample_count(x, y) > 0) continue;
          const size_t pixel = window.index_of(x, y);
          tile.show(x, y, &shown[4 * pixel]);
          if (lights.empty()) continue;
          tile.show_lights(x, y, std::span(lights).subspan(groups * pixel, groups));
        }
      }
      observer.tile_finished(tile);
    }
  };
  const int workers = std::max(1, tbb::this_task_arena::max_concurrency());
  parallel_tasks(std::min(tiles.size(), size_t(workers)), work);
}

}  // namespace emberline
