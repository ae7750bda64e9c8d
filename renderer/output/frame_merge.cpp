#include "renderer/output/frame_merge.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <nlohmann/json.hpp>
#include <numeric>
#include <tuple>

#include "io/json/input.h"
#include "renderer/core/errors.h"
#include "renderer/core/flush_denormals.h"
#include "renderer/core/load_progress.h"
#include "renderer/core/log.h"
#include "renderer/core/parallel.h"
#include "renderer/drivers/bucket_schedule.h"
#include "renderer/engine/film_memory.h"
#include "renderer/output/checkpoint.h"
#include "renderer/output/checkpoint_head.h"
#include "renderer/output/frame_memory.h"
#include "renderer/output/recorded_settings.h"

namespace emberline {
namespace {

FilmExtras extras_of(const RenderPlan& plan, const FrameSettings& settings,
                     const SceneLayers& layers) {
  FilmExtras extras = film_extras(*plan.driver, plan.driver_settings);
  if (settings.light_groups) extras.light_groups = int(layers.lights.size());
  return extras;
}

}  // namespace

StoredFrame::StoredFrame(const std::string& path, MemoryBudget* budget)
    : file_(path),
      head_(parse_json(file_.head(), path)),
      settings_(settings_of(*head_, path)),
      plan_(convert_usage_errors(path, [&] { return RenderPlan(settings_); })),
      layers_(scene_layers_of(*head_, path)),
      extras_(extras_of(plan_, settings_, layers_)),
      is_tiled_(plan_.driver->tiles) {
  // Reserves memory for the bucket lists, because a head of a few kilobytes may imply millions of
  // buckets.
  if (budget) {
    budget->reserve(MemoryPart::kFilm, bucket_list_bytes(plan_.crop, tile_size()), path);
  }
  if (!is_tiled_) return;
  const auto schedule = convert_usage_errors(path, [&] {
    return bucket_schedule(plan_.crop, tile_size(), settings_.bucket_order, plan_.seed);
  });
  const FramePart part = settings_.part.value_or(FramePart{});
  for (size_t i = part.index - 1; i < schedule.size(); i += part.count) {
    part_tiles_.push_back(schedule[i]);
  }
  tiles_.resize(schedule.size());
  for (const RecordEntry& record : file_.records()) {
    if (record.kind == kTileRecord && record.number < tiles_.size())
      tiles_[record.number] = &record;
  }
}

void StoredFrame::load_film(MemoryBudget& budget) {
  if (is_tiled_) return;
  const uint64_t bytes_per_pixel = film_bytes_per_pixel(plan_.aovs, extras_) +
                                   plan_.driver->bytes_per_pixel(plan_.driver_settings);
  // Reserves memory for the film and for the saved state from which the film is read.
  const uint64_t state_bytes = bytes_of(uint64_t(plan_.crop.area()), 2 * bytes_per_pixel);
  budget.reserve(MemoryPart::kFilm, state_bytes, path());
  const auto state = read_film_state(file_, state_bytes + (1 << 20));
  if (!state) return;
  film_.emplace(plan_.aovs, extras_);
  reset_film(plan_.crop, &*film_);
  Archive loading{std::span<const std::byte>(*state)};
  bool finished = false;
  try {
    TileResult result = empty_result();
    result.archive(loading);
    loading.number(finished, false, true);
    film_->archive(loading);
    film_result_ = result;
  } catch (const InputError& error) {
    throw InputError(path(), error.what());
  }
  if (!finished) film_.reset();
}

// Returns a result with the same counters as Frame::empty_counters() of the frame that wrote the
// checkpoint.
TileResult StoredFrame::empty_result() const {
  TileResult result;
  if (settings_.clamp_indirect) {
    result.counters.clamped =
        ClampedLight(*settings_.clamp_indirect, std::max(0, extras_.light_groups));
  }
  return result;
}

bool StoredFrame::has_tile(size_t tile) const {
  return is_tiled_ ? tiles_[tile] != nullptr : film_.has_value();
}

TileResult StoredFrame::load(size_t tile, FilmTile& film, std::vector<std::byte>* driver) const {
  if (!is_tiled_) {
    const Rect& rect = film.rect();
    for (int y = rect.y0; y < rect.y1; ++y) {
      for (int x = rect.x0; x < rect.x1; ++x) film.copy_pixel(*film_, x, y);
    }
    return {};
  }
  const std::vector<std::byte> state =
      file_.read(*tiles_[tile], TileStore::max_state_bytes(film.bytes()));
  Archive loading{std::span<const std::byte>(state)};
  TileResult result = empty_result();
  try {
    result.archive(loading);
    film.archive(loading);
  } catch (const InputError& error) {
    throw InputError(path(), error.what());
  }
  if (driver) driver->assign(loading.rest().begin(), loading.rest().end());
  return result;
}

bool StoredFrame::is_complete_part(const FramePart& part) const {
  if (!is_tiled_ || settings_.part.value_or(FramePart{}) != part) return false;
  FilmTile film(plan_.aovs, extras_);
  try {
    for (const Rect& tile : part_tiles_) {
      if (!has_tile(tile_index(tile))) return false;
      film.reset(tile);
      load(tile_index(tile), film);
    }
  } catch (const InputError&) {
    return false;
  }
  return true;
}

double StoredFrame::completed_fraction() const {
  const auto stored_tiles = std::ranges::count_if(
      part_tiles_, [&](const Rect& tile) { return has_tile(tile_index(tile)); });
  return part_tiles_.empty() ? 1.0 : double(stored_tiles) / double(part_tiles_.size());
}

FrameMerge::FrameMerge(const std::vector<std::string>& paths, bool allow_holes, bool strict,
                       MemoryBudget& budget, std::stop_token stop)
    : stop_(std::move(stop)) {
  for (const std::string& path : paths) {
    check_stop();
    frames_.push_back(std::make_unique<StoredFrame>(path, &budget));
  }
  check_frames(strict);
  const FrameSettings& settings = first().settings();
  // Reserves memory for the bucket schedule and, for each group, for its lists of parts, errors and
  // counts. There are at most as many groups as frames.
  const uint64_t lists = bucket_list_bytes(first().plan().crop, first().tile_size());
  for (size_t i = 0; i <= frames_.size(); ++i) {
    budget.reserve(MemoryPart::kFilm, lists, first().path());
  }
  tiles_ = bucket_schedule(first().plan().crop, first().tile_size(), settings.bucket_order,
                           first().plan().seed);
  for (const auto& frame : frames_) {
    check_stop();
    frame->load_film(budget);
  }
  make_groups();
  check_groups(allow_holes);
}

void FrameMerge::check_stop() const {
  if (stop_.stop_requested()) throw Cancelled();
}

// Each thread holds one film, or two if there are several groups. It also holds either the saved
// state from which it reads a film, or the data that it writes.
void FrameMerge::reserve(const RenderOptions& options, const OutputSettings& settings, int threads,
                         MemoryBudget& budget) const {
  const std::vector<std::string>& lights = first().layers().lights;
  const uint64_t film = film_bytes_per_pixel(settings.aovs, first().film_extras());
  // The tile's state and the packed record each hold the film and the driver's state. The driver's
  // state that was loaded from a part is a third copy.
  const RenderPlan& plan = first().plan();
  const uint64_t driver =
      plan.driver->bytes_per_pixel(plan.driver_settings) + judged_light_bytes(plan, lights.size());
  const uint64_t saved = options.resumable ? 2 * film + 3 * driver : 0;
  const uint64_t bytes_per_pixel =
      (groups_.size() > 1 ? 2 : 1) * film + saved +
      std::max(film, write_bytes_per_pixel(tile_channels(settings, lights).size()));
  const ActiveBuckets at_work = active_buckets(settings.crop, settings.tile_size, threads);
  budget.reserve(MemoryPart::kFilm, bytes_of(at_work.pixels(), bytes_per_pixel), first().path());
  budget.reserve(MemoryPart::kFilm, output_bytes(options, settings, lights), first().path());
}

void FrameMerge::check_frames(bool strict) const {
  for (const auto& frame : frames_) {
    const auto different =
        differences(first().head(), frame->head(), {"part", "sample-range", "seed"});
    if (frame->layers().lights != first().layers().lights) {
      throw InputError(frame->path(), "its light groups differ from those of {}", first().path());
    }
    if (frame->layers().cryptomattes != first().layers().cryptomattes) {
      throw InputError(frame->path(), "the names of its mattes differ from those of {}",
                       first().path());
    }
    if (!different.empty()) {
      throw InputError(frame->path(), "it belongs to another frame than {}: {}", first().path(),
                       fmt::join(different, "; "));
    }
    const auto machines = machine_differences(first().head(), frame->head());
    if (machines.empty()) continue;
    const std::string what =
        fmt::format("{}: it was made with {}; the result may differ in the last bits",
                    frame->path(), fmt::join(machines, "; "));
    if (strict)
      throw InputError(frame->path(), "`strict`: it was made with {}", fmt::join(machines, "; "));
    log_warning(what);
  }
}

// Groups the parts by seed and sample range.
void FrameMerge::make_groups() {
  const auto key = [](const auto& g) { return std::tie(g.seed, g.first_sample, g.end_sample); };
  for (const auto& frame : frames_) {
    Group new_group;
    new_group.seed = frame->plan().seed;
    new_group.first_sample = frame->plan().first_sample;
    new_group.end_sample = new_group.first_sample + frame->plan().samples_per_pixel;
    auto group =
        std::ranges::find_if(groups_, [&](const Group& g) { return key(g) == key(new_group); });
    if (group == groups_.end()) {
      groups_.push_back(new_group);
      group = groups_.end() - 1;
      group->frames_by_tile.resize(tiles_.size());
      group->errors.resize(tiles_.size());
      group->samples.resize(tiles_.size());
    }
    for (size_t tile = 0; tile < tiles_.size(); ++tile) {
      if (!frame->has_tile(tile)) continue;
      const StoredFrame*& slot = group->frames_by_tile[tile];
      if (slot) {
        throw InputError(frame->path(), "it has the same samples as {}; leave one of them out",
                         slot->path());
      }
      slot = frame.get();
    }
  }
  std::ranges::sort(groups_, {}, key);
}

void FrameMerge::check_groups(bool allow_holes) {
  std::vector<std::string> lacking;
  for (size_t g = 0; g < groups_.size(); ++g) {
    const Group& group = groups_[g];
    const bool continues_seed = g > 0 && groups_[g - 1].seed == group.seed;
    const uint32_t expected = continues_seed ? groups_[g - 1].end_sample : 0;
    if (continues_seed && group.first_sample < expected) {
      throw InputError(first().path(), "samples {} to {} are in two of the parts; leave one out",
                       group.first_sample, std::min(group.end_sample, expected) - 1);
    }
    if (group.first_sample > expected) {
      lacking.push_back(fmt::format("samples {} to {}", expected, group.first_sample - 1));
    }
    size_t missing = 0;
    const Rect* hole = nullptr;
    for (const Rect& tile : tiles_) {
      if (group.frames_by_tile[tile_index(tile)]) continue;
      if (missing++ == 0) hole = &tile;
    }
    if (hole) {
      lacking.push_back(fmt::format("{} of {} buckets, the first at {},{}", missing, tiles_.size(),
                                    hole->x0, hole->y0));
    }
  }
  complete_ = lacking.empty();
  if (complete_) return;
  const std::string what = fmt::format("{}", fmt::join(lacking, "; "));
  if (!allow_holes) {
    throw InputError(first().path(),
                     "the parts lack {}; render the missing parts, or use `allow-holes`", what);
  }
  log_warning(fmt::format("the parts lack {}: pixels without samples are black", what));
}

FrameSettings FrameMerge::settings() const {
  FrameSettings settings = first().settings();
  settings.part.reset();
  if (settings.sample_range) {
    settings.sample_range.reset();
    settings.spp = groups_.back().end_sample;
  }
  return settings;
}

// Adds up the films that the groups have for this tile. Adds the samples of a pixel seed by seed
// and, within a seed, in the order of their indices.
void FrameMerge::merge_tile(const Rect& tile, FilmTile& film, FilmTile& more,
                            RenderCounters& counters, const SaveTile& save) {
  const size_t number = tile_index(tile);
  film.reset(tile);
  bool has_samples = false;
  TileResult merged;
  std::vector<std::byte> driver;
  for (Group& group : groups_) {
    const StoredFrame* frame = group.frames_by_tile[number];
    if (!frame) continue;
    FilmTile& to = has_samples ? more : film;
    to.reset(tile);
    const TileResult result = frame->load(number, to, save ? &driver : nullptr);
    if (has_samples) {
      film.add_film(more);
      merged.counters.merge(result.counters);
      merged.min_samples += result.min_samples;
    } else {
      merged = result;
    }
    has_samples = true;
    film.set_part(uint32_t(part_number(frame)));
    group.errors[number] = result.error;
    group.samples[number] = result.counters.samples;
    counters.merge(result.counters);
  }
  for (size_t i = 0; i < size_t(tile.area()); ++i) {
    merged.counters.max_samples =
        std::max(merged.counters.max_samples, uint32_t(film.sums(i).samples()));
  }
  counters.max_samples = std::max(counters.max_samples, merged.counters.max_samples);
  if (!save || !has_samples) return;
  // The driver state that was loaded last is correct for the merged tile. A uniform driver's state
  // does not depend on the number of samples. Other drivers have only one state per tile, because
  // they cannot render ranges of samples.
  std::vector<std::byte> state;
  state.reserve(film.bytes() + driver.size() + 4096);
  Archive saving(state);
  merged.archive(saving);
  film.archive(saving);
  saving.values(std::span(driver));
  saving.end();
  save(number, state);
}

size_t FrameMerge::part_number(const StoredFrame* frame) const {
  const auto at = std::ranges::find(frames_, frame, &std::unique_ptr<StoredFrame>::get);
  return size_t(at - frames_.begin()) + 1;
}

void FrameMerge::deliver(const AovSet& aovs, RenderSink& sink, const SaveTile& save) {
  std::atomic<size_t> next{0};
  std::atomic<uint32_t> lowest{UINT32_MAX};
  std::atomic<uint64_t> unsampled{0};
  std::mutex mutex;
  parallel_tasks(std::min(tiles_.size(), worker_count()), [&](size_t) {
    const FlushDenormals flush;  // as the render workers do
    FilmTile film(aovs, first().film_extras());
    FilmTile more(aovs, first().film_extras());
    RenderCounters counters;
    for (size_t i = next++; i < tiles_.size() && !stop_.stop_requested(); i = next++) {
      merge_tile(tiles_[i], film, more, counters, save);
      uint32_t before = lowest;
      while (before > film.min_samples() &&
             !lowest.compare_exchange_weak(before, film.min_samples())) {
      }
      unsampled += count_unsampled(film);
      sink.tile_finished(film);
    }
    const std::lock_guard lock(mutex);
    counters_.merge(counters);
  });
  check_stop();
  for (const auto& frame : frames_) {
    if (frame->film_result()) counters_.merge(frame->film_result()->counters);
  }
  counters_.min_samples = tiles_.empty() ? 0 : lowest.load();
  unsampled_pixels_ = unsampled.load();
  combine_errors();
}

// Combines the groups' independent error estimates, weighting each group by its sample count.
void FrameMerge::combine_errors() {
  double sum = 0, samples = 0;
  std::optional<double> error;
  for (const Group& group : groups_) {
    std::vector<std::optional<double>> ordered_errors;
    for (const Rect& tile : tiles_) ordered_errors.push_back(group.errors[tile_index(tile)]);
    error = error_of_tiles(tiles_, ordered_errors);
    auto group_samples = std::accumulate(group.samples.begin(), group.samples.end(), uint64_t(0));
    const StoredFrame* frame =
        group.frames_by_tile.empty() ? nullptr : group.frames_by_tile.front();
    if (frame && frame->film_result()) {
      error = frame->film_result()->error;
      group_samples = frame->film_result()->counters.samples;
    }
    if (!error) return;
    sum += square(double(group_samples) * *error);
    samples += double(group_samples);
  }
  if (samples > 0) error_ = groups_.size() == 1 ? *error : std::sqrt(sum) / samples;
}

}  // namespace emberline
