#include "renderer/engine/frame_render.h"

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <new>

#include "renderer/core/errors.h"
#include "renderer/core/flush_denormals.h"
#include "renderer/core/parallel.h"
#include "renderer/drivers/bucket_schedule.h"
#include "renderer/engine/render_worker.h"
#include "renderer/engine/shared_tiles.h"
#include "renderer/film/light_mix.h"

namespace emberline {
namespace {

size_t worker_count() { return size_t(std::max(1, tbb::this_task_arena::max_concurrency())); }

// What each light group, or layer by light path, gives to each pixel of an incomplete picture, by
// pixel, then by group.
std::vector<Rgb> shown_groups(const FramePicture& picture, LightMix::Of of, size_t groups) {
  const auto pixels = size_t(picture.film().rect().area());
  std::vector<Rgb> lights(groups * pixels);
  std::vector<float> rgba(4 * pixels);
  for (size_t g = 0; g < groups; ++g) {
    std::vector<Rgb> weights(groups, Rgb(0.0f));
    weights[g] = Rgb(1.0f);
    const LightMix alone(weights, of);
    picture.resolve(rgba, &alone);
    for (size_t i = 0; i < pixels; ++i) std::copy_n(&rgba[4 * i], 3, &lights[groups * i + g].x);
  }
  return lights;
}

// How many parts from `begin` on come before the next pause: all, unless a picture is wanted with
// so many samples.
size_t pause_after(const FrameDriver& driver, const Round& round, size_t begin,
                   std::optional<uint64_t> samples_wanted) {
  if (!samples_wanted) return round.parts;
  size_t end = begin;
  for (uint64_t samples = 0; end < round.parts && samples < *samples_wanted; ++end) {
    samples += driver.samples(end);
  }
  return end;
}

// Puts the driver's own picture into the film, where it is another than the film's means.
void show_picture(const FrameDriver& driver, FilmTile& film) {
  if (!driver.shows_other_means()) return;
  const Rect& pixels = film.rect();
  std::vector<float> shown(4 * size_t(pixels.area()));
  driver.resolve(film, shown, nullptr);
  for (size_t i = 0; i < size_t(pixels.area()); ++i) {
    film.show(pixels.x_of(i), pixels.y_of(i), &shown[4 * i]);
  }
}

}  // namespace

void TileResult::archive(Archive& archive) {
  double value = error.value_or(-1.0);
  archive.number(value, -1.0, std::numeric_limits<double>::max());
  archive.check(value == -1.0 || value >= 0.0);
  error = value >= 0.0 ? std::optional(value) : std::nullopt;
  archive.number(least_samples, 0u, UINT32_MAX);
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

// One frame's workers, and what they count.
class FrameRender::Loop {
 public:
  Loop(const Frame& the_frame, FrameObserver& the_observer, std::stop_token the_stop,
       FrameCounters& the_counters)
      : frame(the_frame),
        observer(the_observer),
        stop(std::move(the_stop)),
        counters(the_counters) {}

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
        RenderWorker worker(frame);
        work(worker, going);
        count(worker.take_counters());
      } catch (...) {
        failed = true;  // the others need not finish a frame that is lost
        throw;
      }
    });
  }

  void count(const FrameCounters& more) {
    const std::lock_guard lock(mutex_);
    counters.merge(more);
  }

  // The parts [begin, end) of the round under way, or fewer if a picture is wanted soon.
  RenderedParts carry_out(RoundWork& work) {
    share(work.parts_left(), [&](RenderWorker& worker, const auto& going) {
      bool took_one = false;
      work.take_parts(worker, observer, stop, [&] {
        if (took_one && observer.picture_wanted()) return false;
        took_one = true;
        return going();
      });
    });
    return work.rendered(stop.stop_requested());
  }

  const Frame& frame;
  FrameObserver& observer;
  const std::stop_token stop;
  FrameCounters& counters;

 private:
  std::mutex mutex_;
};

FrameCounters FrameRender::render(const Frame& frame, FrameObserver& observer,
                                  std::stop_token stop) {
  Loop loop(frame, observer, std::move(stop), counters_);
  drivers_.tiles ? render_tiles(loop) : render_crop(loop);
  return counters_;
}

void FrameRender::begin(const Frame& frame) {
  film_.emplace(frame.aovs, frame.with_light_groups(drivers_.film_extras));
  reset_film(frame.crop, &*film_);
  driver_ = drivers_.create(frame, frame.crop);
  counters_ = frame.no_counts();
}

void FrameRender::archive(Archive& archive) {
  TileResult result{driver_->error_estimate(), driver_->least_samples(*film_), counters_};
  bool finished = driver_->finished();
  result.archive(archive);
  archive.number(finished, false, true);
  film_->archive(archive);
  driver_->archive(archive, *film_);
  counters_ = result.counters;
  archive.number(parts_done_, size_t(0), driver_->round().parts);
}

void FrameRender::save(std::vector<std::byte>& state) {
  Archive saving(state);
  archive(saving);
  saving.end();
}

void FrameRender::resumable(const Frame& frame) {
  resumable_ = true;
  begin(frame);
}

void FrameRender::load(std::span<const std::byte> state) {
  Archive loading(state);
  archive(loading);
  loading.end();
  film_is_ahead_ = true;
}

void FrameRender::extend(std::span<const std::byte> finished) {
  Archive loading(finished);
  TileResult result{.counters = counters_};
  bool is_finished = false;
  result.archive(loading);
  loading.number(is_finished, false, true);
  loading.check(is_finished);
  film_->archive(loading);
  film_->show_means();
  driver_->extend(loading, *film_);
  counters_ = result.counters;
  film_is_ahead_ = true;
}

void FrameRender::render_crop(Loop& loop) {
  if (!driver_) begin(loop.frame);
  FrameProgress progress;
  while (!driver_->finished()) {
    if (parts_done_ == driver_->round().parts) {
      if (!driver_->next(*film_, resumable_ ? std::stop_token() : loop.stop)) break;
      parts_done_ = 0;
    }
    const Round round = driver_->round();
    std::optional<uint64_t> wanted = loop.observer.picture_wanted_at();
    if (wanted) *wanted = std::max(*wanted, counters_.samples + 1) - counters_.samples;
    const size_t end = pause_after(*driver_, round, parts_done_, wanted);
    RoundWork work(*driver_, *film_, parts_done_, end, film_is_ahead_);
    const RenderedParts parts = loop.carry_out(work);
    if (!parts.complete) loop.observer.cut_short();
    driver_->rendered(parts, *film_);
    if (!parts.complete) break;
    const bool round_done = parts.end == round.parts;
    // A driver that needs a round no more may have let it go by now.
    parts_done_ = round_done ? driver_->round().parts : parts.end;
    progress.pass = round.pass;
    progress.samples = counters_.samples;
    progress.rays = counters_.rays.total();
    progress.completion = std::min(1.0, double(progress.samples) / double(loop.frame.crop.area()));
    progress.pass_finished = round.ends_pass && round_done;
    progress.error_estimate = driver_->error_estimate();
    loop.observer.picture_changed(progress, *this);
  }
  counters_.min_samples = driver_->least_samples(*film_);
  counters_.stopped = !driver_->finished();
}

// All rounds of one tile.
void FrameRender::render_tile(Loop& loop, TileOwner& owner, RenderWorker& worker,
                              FrameDriver& driver, FilmTile& film, TileResult& result) {
  const bool film_is_ahead = result.counters.samples > 0;
  for (bool complete = true; complete;) {
    const std::optional<Round> round = driver.next(film, {});
    if (!round) break;
    RoundWork work(driver, film, 0, round->parts, film_is_ahead);
    owner.carry_out(work, worker, result.counters);
    const RenderedParts parts = work.rendered(loop.stop.stop_requested());
    driver.rendered(parts, film);
    complete = parts.complete;
  }
  driver.end(film, loop.observer.stop_cause());
  show_picture(driver, film);
  result.counters.merge(worker.take_counters());
  result.error = driver.error_estimate();
  result.least_samples = driver.least_samples(film);
}

// Workers take the next tile from a counter rather than a share of the list in advance, so the
// order is kept whatever the threads' speeds. One increment per tile is no contention. With its
// tiles a thread is isolated: while it waits for help with a decision, it must not begin what waits
// for its tile.
void FrameRender::render_tiles(Loop& loop) {
  const Frame& frame = loop.frame;
  const std::vector<Rect> tiles = tiles_of(frame);
  std::atomic<size_t> next{0};
  std::atomic<bool> all_finished{true};
  std::vector<std::optional<double>> errors(tiles.size());  // summed in order, whoever brought them
  std::vector<uint32_t> least(tiles.size(), 0);
  SharedTiles shared(loop.observer, loop.stop);
  const auto take_tiles = [&](RenderWorker& worker, const auto& going) {
    TileOwner owner(shared);
    FilmTile film(frame.aovs, frame.with_light_groups(drivers_.film_extras));
    while (going()) {
      const size_t i = next.fetch_add(1, std::memory_order_relaxed);
      if (i >= tiles.size()) break;
      TileResult result{.counters = frame.no_counts()};
      if (!load_tile(loop, tiles[i], film, result)) {
        loop.observer.tile_begun(tiles[i]);
        const std::unique_ptr<FrameDriver> driver = begin_tile(loop, tiles[i], film, result);
        render_tile(loop, owner, worker, *driver, film, result);
        if (!driver->finished()) all_finished = false;
        if (driver->finished() && store_) save_tile(frame.crop, *driver, film, result);
        loop.observer.tile_finished(film);
      }
      loop.count(result.counters);
      errors[i] = result.error;
      least[i] = result.least_samples;
    }
  };
  // A row of a tile is worth sharing.
  loop.share(tiles.size() * size_t(drivers_.tile_size),
             [&](RenderWorker& worker, const auto& going) {
               tbb::this_task_arena::isolate([&] { take_tiles(worker, going); });
               shared.help(worker);
             });
  counters_.stopped = !all_finished || next.load() < tiles.size();
  counters_.min_samples = tiles.empty() ? 0 : *std::ranges::min_element(least);
  tiles_error_ = error_of_tiles(tiles, errors);
}

// The tiles of this part of the frame, in their order.
std::vector<Rect> FrameRender::tiles_of(const Frame& frame) const {
  const std::vector<Rect> all =
      bucket_schedule(frame.crop, drivers_.tile_size, drivers_.tile_order, frame.seed);
  std::vector<Rect> tiles;
  for (size_t i = drivers_.part.index - 1; i < all.size(); i += drivers_.part.count) {
    tiles.push_back(all[i]);
  }
  return tiles;
}

void FrameRender::save_tile(const Rect& crop, FrameDriver& driver, FilmTile& film,
                            TileResult& result) {
  std::vector<std::byte> state;
  state.reserve(film.bytes() + driver.bytes() + 4096);
  Archive saving(state);
  result.archive(saving);
  film.archive(saving);
  driver.archive(saving, film);
  store_->save(bucket_number(crop, film.rect(), drivers_.tile_size), state);
}

// With what a frame of fewer samples has of it, where that can be used.
std::unique_ptr<FrameDriver> FrameRender::begin_tile(Loop& loop, const Rect& tile, FilmTile& film,
                                                     TileResult& result) {
  film.reset(tile);
  std::unique_ptr<FrameDriver> driver = drivers_.create(loop.frame, tile);
  if (!store_) return driver;
  const auto finished = store_->load_finished(
      bucket_number(loop.frame.crop, tile, drivers_.tile_size), most_of_state(film.bytes()));
  if (!finished) return driver;
  try {
    Archive loading{std::span<const std::byte>(*finished)};
    result.archive(loading);
    film.archive(loading);
    film.show_means();
    driver->extend(loading, film);
  } catch (const InputError&) {
    store_->unusable(true);
    result = {.counters = loop.frame.no_counts()};
    film.reset(tile);
    return drivers_.create(loop.frame, tile);
  }
  loop.observer.samples_loaded(result.counters.samples);
  return driver;
}

// False: it is to be rendered. A stored tile that cannot be used is as good as none.
bool FrameRender::load_tile(Loop& loop, const Rect& tile, FilmTile& film, TileResult& result) {
  if (!store_) return false;
  film.reset(tile);
  const auto state = store_->load(bucket_number(loop.frame.crop, tile, drivers_.tile_size),
                                  most_of_state(film.bytes()));
  if (!state) return false;
  try {
    Archive loading{std::span<const std::byte>(*state)};
    result.archive(loading);
    film.archive(loading);
    const std::unique_ptr<FrameDriver> driver = drivers_.create(loop.frame, tile);
    driver->archive(loading, film);
    loading.check(driver->finished());
    loading.end();
  } catch (const InputError&) {
    store_->unusable(false);
    result = {.counters = loop.frame.no_counts()};
    return false;
  }
  loop.observer.tile_loaded(film, result.counters.samples);
  return true;
}

uint64_t FrameRender::bytes_per_pixel(const AovSet& aovs) const {
  return drivers_.tiles
             ? 0
             : film_bytes_per_pixel(aovs, drivers_.film_extras) + drivers_.bytes_per_pixel;
}

uint64_t shown_layer_bytes_per_pixel(size_t layers) {
  return layers * sizeof(Rgb) + (layers > 0 ? 4 * sizeof(float) : 0);
}

uint64_t FrameRender::tile_bytes_per_pixel(const AovSet& aovs) const {
  const uint64_t of_driver = drivers_.tiles ? drivers_.bytes_per_pixel : 0;
  return film_bytes_per_pixel(aovs, drivers_.film_extras) + of_driver;
}

std::optional<double> FrameRender::error_estimate() const {
  return driver_ ? driver_->error_estimate() : tiles_error_;
}

void FrameRender::end(PixelStop cut_short) {
  if (!driver_) return;
  driver_->end(*film_, cut_short);
  show_picture(*driver_, *film_);
}

// Tiles of the bucket driver's size, aligned as they are. Pixels without samples are shown as the
// picture has them.
void FrameRender::deliver(FrameObserver& observer) {
  if (!driver_) return;
  end(observer.stop_cause());
  const Rect& crop = film_->rect();
  const std::vector<Rect> tiles =
      bucket_schedule(crop, drivers_.tile_size, BucketOrder::kScanline, 0);
  // Before the workers begin: one that waits for help with it must not begin a tile that needs it.
  std::vector<float> shown;
  if (film_->least_samples() == 0) {
    shown.resize(4 * size_t(crop.area()));
    resolve(shown);
  }
  const auto groups = size_t(std::max(0, film_->light_groups().groups()));
  const auto layers = size_t(std::max(0, film_->path_layers().groups()));
  std::vector<Rgb> lights, paths;
  if (!shown.empty() && groups > 0) lights = shown_groups(*this, LightMix::Of::kLights, groups);
  if (!shown.empty() && layers > 0) paths = shown_groups(*this, LightMix::Of::kPaths, layers);
  std::atomic<size_t> next{0};
  const auto work = [&](size_t /*worker*/) {
    const FlushDenormals flush;                     // as the workers that hand tiles on
    FilmTile tile(film_->aovs(), film_->extras());  // one each: its memory serves again and again
    for (size_t i = next++; i < tiles.size(); i = next++) {
      const Rect& rect = tiles[i];
      tile.reset(rect);
      for (int y = rect.y0; y < rect.y1; ++y) {
        for (int x = rect.x0; x < rect.x1; ++x) {
          tile.copy_pixel(*film_, x, y);
          if (film_->sample_count(x, y) > 0) continue;
          const size_t pixel = crop.index_of(x, y);
          tile.show(x, y, &shown[4 * pixel]);
          if (groups > 0) tile.show_lights(x, y, std::span(lights).subspan(groups * pixel, groups));
          if (layers > 0) tile.show_layers(x, y, std::span(paths).subspan(layers * pixel, layers));
        }
      }
      observer.tile_finished(tile);
    }
  };
  parallel_tasks(std::min(tiles.size(), worker_count()), work);
}

uint64_t film_bytes_per_pixel(const AovSet& aovs, const FilmExtras& extras) {
  FilmTile pixel(aovs, extras);
  pixel.reset({0, 0, 1, 1});
  return pixel.bytes() + 4 * sizeof(float);
}

void reset_film(const Rect& crop, FilmTile* film) {
  try {
    film->reset(crop);
  } catch (const std::bad_alloc&) {
    throw RenderError(
        fmt::format("not enough memory to hold a film of {}x{} pixels; `driver` bucket needs no "
                    "more for a larger frame",
                    crop.width(), crop.height()));
  }
}

}  // namespace emberline
